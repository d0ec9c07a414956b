//! Rows scaled to unit length, side by side in one block, with the Cholesky factor of their Gram matrix among them.

use std::sync::Arc;

use super::envelope::EnvelopeCholesky;
use super::order::{narrow, size_of};
use super::system::{SparseRows, norm};

/// The most numbers an envelope may have.
const ENVELOPE_LIMIT: usize = 200_000_000;

/// Where a row's numbers are in the block: its entries, `L` from `first` to the reciprocal of the diagonal, and the
/// reciprocal of its length.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// The row of the system.
    row: u32,
    /// The first position whose row shares a column with it.
    first: u32,
    /// Its first column.
    column: u32,
    entries: u32,
    at: usize,
    /// Its entry of `L⁻¹ s`, for signs `s` that let it grow.
    growth: f64,
}

/// Independent rows of unit length, in an order that keeps `F̂ = L Lᵀ` narrow, and scratch for an event. A few rows need
/// no memory of their own.
#[derive(Debug)]
pub(super) struct UnitRows {
    places: Vec<Place>,
    numbers: Vec<f64>,
    /// Where the scratch starts.
    scratch: usize,
    /// The rows' columns, unless those of each row are neighbours.
    columns: Option<Arc<SparseRows>>,
    /// The largest of the rows' growths.
    growth: f64,
}

/// What keeps rows from being factored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Failure {
    /// A pivot that is not above the threshold, or a row without a length.
    Pivot,
    /// An envelope of too many numbers.
    TooLarge,
}

impl UnitRows {
    /// No rows yet. Rows are put where they stay: moving them would cost more than scaling a few.
    #[inline]
    pub(super) fn empty() -> Self {
        Self { places: Vec::new(), numbers: Vec::new(), scratch: 0, columns: None, growth: 1.0 }
    }

    /// Orders and scales the kept rows and factors `F̂`.
    ///
    /// # Errors
    /// When a pivot (of unit rows: the squared sine of the angle to the rows before) is not above `threshold`, or
    /// [`weakness`](Self::weakness) is not: small pivots are noise where the factors of the rows before have grown, however
    /// large each of their pivots is.
    pub(super) fn factor(
        &mut self,
        rows: &Arc<SparseRows>,
        kept: impl ExactSizeIterator<Item = u32> + Clone,
        sides: usize,
        threshold: f64,
    ) -> Result<(), Failure> {
        let room = rows.entries() + 5 * kept.len() + kept.len() * sides;
        self.columns = None;
        self.clear(kept.len(), room);
        if !self.runs(rows, kept.clone(), threshold)? {
            self.columns = Some(Arc::clone(rows));
            self.general(rows, kept.collect(), threshold)?;
        }
        self.scratch = self.numbers.len();
        self.numbers.resize(self.scratch + self.places.len() * sides, 0.0);
        Ok(())
    }

    /// No rows, and room for some.
    fn clear(&mut self, rows: usize, numbers: usize) {
        self.places.clear();
        self.places.reserve_exact(rows);
        self.numbers.clear();
        self.numbers.reserve_exact(numbers);
        self.growth = 1.0;
    }

    /// Scales the kept rows, in the order given, without a factor, with `scratch` zeros beside them; whether all have a
    /// length.
    pub(super) fn scale(
        &mut self,
        rows: &Arc<SparseRows>,
        kept: impl ExactSizeIterator<Item = u32>,
        scratch: usize,
    ) -> bool {
        self.clear(kept.len(), rows.entries() + 2 * kept.len() + scratch);
        let mut neighbours = true;
        for (position, row) in kept.enumerate() {
            let (columns, values) = rows.row(row as usize);
            let (Some(&column), Some(&last)) = (columns.first(), columns.last()) else { return false };
            neighbours &= (last - column) as usize + 1 == columns.len();
            let entries = columns.len() as u32;
            let at = self.numbers.len();
            let place = Place { row, first: position as u32, column, entries, at, growth: 1.0 };
            let scale = 1.0 / norm(values);
            if !(scale.is_finite() && scale > 0.0) {
                return false;
            }
            self.numbers.extend(values.iter().map(|v| v * scale));
            self.numbers.extend([1.0, scale]);
            self.places.push(place);
        }
        self.columns = (!neighbours).then(|| Arc::clone(rows));
        self.scratch = self.numbers.len();
        self.numbers.resize(self.scratch + scratch, 0.0);
        true
    }

    /// Appends rows of neighbouring columns that come by ascending first column, as stencils of curves do: the envelope
    /// follows from first and last columns alone. False for others, and where another order may be narrower.
    fn runs(
        &mut self,
        rows: &SparseRows,
        kept: impl ExactSizeIterator<Item = u32>,
        threshold: f64,
    ) -> Result<bool, Failure> {
        let (mut envelope, mut first, mut before) = (0, 0, 0);
        for (position, row) in kept.enumerate() {
            let (columns, values) = rows.row(row as usize);
            let (Some(&column), Some(&last)) = (columns.first(), columns.last()) else {
                return Err(Failure::Pivot);
            };
            if (last - column) as usize + 1 != columns.len() || column < before {
                return Ok(false);
            }
            before = column;
            // A row that ends before this one's first column meets none of the later ones either.
            while self.places.get(first).is_some_and(|p| p.column + p.entries <= column) {
                first += 1;
            }
            envelope += position - first + 1;
            if position >= 16 && envelope > 8 * (position + 1) {
                return Ok(false);
            }
            self.append(rows, row, first, column, values, threshold)?;
        }
        Ok(true)
    }

    /// Appends any rows, in an order that keeps their envelope small.
    fn general(&mut self, rows: &SparseRows, kept: Vec<u32>, threshold: f64) -> Result<(), Failure> {
        if kept.iter().any(|&r| rows.row(r as usize).0.is_empty()) {
            return Err(Failure::Pivot);
        }
        let (order, first) = narrow(rows, kept);
        let size = size_of(&first);
        if size > ENVELOPE_LIMIT {
            return Err(Failure::TooLarge);
        }
        self.clear(order.len(), self.numbers.capacity().max(rows.entries() + size));
        for (&row, &first) in order.iter().zip(&first) {
            self.append(rows, row, first as usize, 0, rows.row(row as usize).1, threshold)?;
        }
        Ok(())
    }

    /// Appends a row: scaled to unit length, and its row of `L`.
    #[inline]
    fn append(
        &mut self,
        rows: &SparseRows,
        row: u32,
        first: usize,
        column: u32,
        values: &[f64],
        threshold: f64,
    ) -> Result<(), Failure> {
        let (i, at) = (self.places.len(), self.numbers.len());
        let scale = 1.0 / norm(values);
        if !(scale.is_finite() && scale > 0.0) {
            return Err(Failure::Pivot);
        }
        let entries = values.len() as u32;
        let mut place = Place { row, first: first as u32, column, entries, at, growth: 1.0 };
        self.numbers.extend(values.iter().map(|v| v * scale));
        let mut reciprocal = 1.0;
        if first < i {
            let (squares, grown) = self.eliminate(rows, &place, scale);
            let pivot = 1.0 - squares;
            reciprocal = 1.0 / pivot.sqrt();
            let growth = (1.0 + grown.abs()) * reciprocal;
            // Written so that NaN fails too.
            if !(pivot > threshold && growth * growth * threshold < 1.0) {
                return Err(Failure::Pivot);
            }
            self.growth = self.growth.max(growth);
            place.growth = if grown > 0.0 { -growth } else { growth };
        }
        self.numbers.extend([reciprocal, scale]);
        self.places.push(place);
        Ok(())
    }

    /// The row of `L` before the diagonal of the row that is being appended; the sum of its squares, and its product with what
    /// has grown.
    fn eliminate(&mut self, rows: &SparseRows, place: &Place, scale: f64) -> (f64, f64) {
        let (i, first) = (self.places.len(), place.first as usize);
        self.numbers.resize(self.numbers.len() + i - first, 0.0);
        let (done, own) = self.numbers.split_at_mut(place.at);
        let (unit, lower) = own.split_at_mut(place.entries as usize);
        let (mut squares, mut grown) = (0.0, 0.0);
        for (j, other) in self.places.iter().enumerate().skip(first) {
            let (theirs, row, reciprocal) = other.split(j, done);
            let dot = match self.columns {
                None => overlap(theirs, unit, (place.column - other.column) as usize),
                Some(_) => rows.dot(other.row as usize, place.row as usize) * scale * done[other.end(j) - 1],
            };
            let start = first.max(other.first as usize);
            let (mine, row) = (&lower[start - first..j - first], &row[start - other.first as usize..]);
            let value = (dot - mine.iter().zip(row).map(|(a, b)| a * b).sum::<f64>()) * reciprocal;
            lower[j - first] = value;
            squares += value * value;
            grown += value * other.growth;
        }
        (squares, grown)
    }

    /// What is beside the rows, to be kept there.
    pub(super) fn beside(&self) -> &[f64] {
        &self.numbers[self.scratch..]
    }

    /// The same, to be changed.
    pub(super) fn beside_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.scratch..]
    }

    /// Which rows of the system they are.
    pub(super) fn kept(&self) -> impl Iterator<Item = u32> + '_ {
        self.places.iter().map(|place| place.row)
    }

    /// The number of rows.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// An estimate, from above, of the smallest eigenvalue of `F̂`: 1 where the rows are orthogonal, small where they are nearly
    /// dependent. It is that of `L Lᵀ`, which differs from `F̂` by no more than some `ε` a row; if it is well above that, the
    /// rows are independent. No pivot need be small for this to be: where each row leans on the one before, factors grow along
    /// the chain. So `‖L⁻¹‖` is followed, from below, by `L⁻¹ s` with each sign `s` chosen so that the next entry grows (Cline,
    /// Moler, Stewart and Wilkinson 1979).
    pub(super) fn weakness(&self) -> f64 {
        1.0 / (self.growth * self.growth)
    }

    /// Estimate of the condition number of the rows.
    pub(super) fn condition(&self) -> f64 {
        let rows = self.places.iter().enumerate().map(|(i, p)| {
            let (_, row, reciprocal) = p.split(i, &self.numbers);
            (p.first, row.iter().copied().chain([reciprocal]))
        });
        EnvelopeCholesky::from_rows(rows).condition().sqrt()
    }

    /// `e ← e + Fᵀ F̂⁻¹ (b - F e)` where `again`, `e ← Fᵀ F̂⁻¹ b` (with `e` zero before) where not.
    pub(super) fn adjust(&mut self, rhs: &[f64], sides: usize, e: &mut [f64], again: bool) {
        match sides {
            3 => self.adjust_side::<3>(rhs, 3, 0, e, again),
            _ => (0..sides).for_each(|side| self.adjust_side::<1>(rhs, sides, side, e, again)),
        }
    }

    fn adjust_side<const S: usize>(
        &mut self,
        rhs: &[f64],
        sides: usize,
        side: usize,
        e: &mut [f64],
        again: bool,
    ) {
        let e = e.get_mut(side..).unwrap_or_default();
        self.forward::<S>(rhs, sides, side, again.then_some(&*e));
        let columns = self.columns.as_deref();
        let (numbers, y) = self.numbers.split_at_mut(self.scratch);
        let (y, _) = y.as_chunks_mut::<S>();
        for (i, place) in self.places.iter().enumerate().rev() {
            let (unit, row, reciprocal) = place.split(i, numbers);
            let value = y[i].map(|v| v * reciprocal);
            for (l, y) in row.iter().zip(&mut y[place.first as usize..]) {
                for s in 0..S {
                    y[s] -= l * value[s];
                }
            }
            add(columns, place, unit, value, e, sides);
        }
    }

    /// `y ← L⁻¹ S (b - F e)`.
    fn forward<const S: usize>(&mut self, rhs: &[f64], sides: usize, side: usize, e: Option<&[f64]>) {
        let columns = self.columns.as_deref();
        let (numbers, y) = self.numbers.split_at_mut(self.scratch);
        let (y, _) = y.as_chunks_mut::<S>();
        for (i, place) in self.places.iter().enumerate() {
            let (unit, row, reciprocal) = place.split(i, numbers);
            let scale = numbers[place.end(i) - 1];
            let b = &rhs[place.row as usize * sides + side..][..S];
            let mut sum = [0.0; S];
            (0..S).for_each(|s| sum[s] = b[s] * scale);
            if let Some(e) = e {
                let column = |k: usize| match columns {
                    None => place.column as usize + k,
                    Some(rows) => rows.row(place.row as usize).0[k] as usize,
                };
                for (k, v) in unit.iter().enumerate() {
                    let e = &e[column(k) * sides..][..S];
                    (0..S).for_each(|s| sum[s] -= v * e[s]);
                }
            }
            for (l, y) in row.iter().zip(&y[place.first as usize..]) {
                for s in 0..S {
                    sum[s] -= l * y[s];
                }
            }
            y[i] = sum.map(|s| s * reciprocal);
        }
    }

    /// The row of the system at position `i`, its columns and its entries of unit length, and its reciprocal length.
    pub(super) fn row(&self, i: usize) -> (usize, impl Iterator<Item = (usize, f64)>, f64) {
        let place = &self.places[i];
        let (unit, ..) = place.split(i, &self.numbers);
        let known = self.columns.as_ref().map(|rows| rows.row(place.row as usize).0);
        let column = move |k: usize| known.map_or(place.column as usize + k, |columns| columns[k] as usize);
        let entries = unit.iter().enumerate().map(move |(k, &v)| (column(k), v));
        (place.row as usize, entries, self.numbers[place.end(i) - 1])
    }

    /// The inner product of two unit rows.
    pub(super) fn dot(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (&self.places[i], &self.places[j]);
        let ((first, ..), (second, ..)) = (a.split(i, &self.numbers), b.split(j, &self.numbers));
        match &self.columns {
            None if a.column <= b.column => overlap(first, second, (b.column - a.column) as usize),
            None => overlap(second, first, (a.column - b.column) as usize),
            Some(rows) => {
                let scales = self.numbers[a.end(i) - 1] * self.numbers[b.end(j) - 1];
                rows.dot(a.row as usize, b.row as usize) * scales
            }
        }
    }

    /// `e ← e + value × row i`.
    pub(super) fn add<const S: usize>(&self, i: usize, value: [f64; S], e: &mut [f64], sides: usize) {
        let place = &self.places[i];
        let (unit, ..) = place.split(i, &self.numbers);
        add(self.columns.as_deref(), place, unit, value, e, sides);
    }

    /// `λ = S F̂⁻¹ S b` into the rows that are kept.
    pub(super) fn multipliers(&mut self, rhs: &[f64], sides: usize, multipliers: &mut [f64]) {
        for side in 0..sides {
            self.forward::<1>(rhs, sides, side, None);
            let (numbers, y) = self.numbers.split_at_mut(self.scratch);
            for (i, place) in self.places.iter().enumerate().rev() {
                let (_, row, reciprocal) = place.split(i, numbers);
                let value = y[i] * reciprocal;
                for (l, y) in row.iter().zip(&mut y[place.first as usize..]) {
                    *y -= l * value;
                }
                multipliers[place.row as usize * sides + side] = value * numbers[place.end(i) - 1];
            }
        }
    }
}

impl Place {
    /// Where its numbers end, at position `i`.
    fn end(&self, i: usize) -> usize {
        self.at + self.entries as usize + i - self.first as usize + 2
    }

    /// At position `i`: the unit row, its row of `L` before the diagonal, and the diagonal's reciprocal.
    fn split<'a>(&self, i: usize, numbers: &'a [f64]) -> (&'a [f64], &'a [f64], f64) {
        let (unit, rest) = numbers[self.at..].split_at(self.entries as usize);
        let (row, rest) = rest.split_at(i - self.first as usize);
        (unit, row, rest[0])
    }
}

/// `e ← e + value × row`, `sides` numbers a column.
#[inline]
fn add<const S: usize>(
    columns: Option<&SparseRows>,
    place: &Place,
    unit: &[f64],
    value: [f64; S],
    e: &mut [f64],
    sides: usize,
) {
    match columns {
        None if S == sides => {
            let (e, _) = e.as_chunks_mut::<S>();
            for (v, e) in unit.iter().zip(&mut e[place.column as usize..]) {
                for s in 0..S {
                    e[s] += v * value[s];
                }
            }
        }
        None => {
            for (v, e) in unit.iter().zip(e[place.column as usize * sides..].chunks_mut(sides)) {
                (0..S).for_each(|s| e[s] += v * value[s]);
            }
        }
        Some(rows) => {
            for (v, &column) in unit.iter().zip(rows.row(place.row as usize).0) {
                let e = &mut e[column as usize * sides..][..S];
                (0..S).for_each(|s| e[s] += v * value[s]);
            }
        }
    }
}

/// The inner product of two runs of neighbouring columns, the second `shift` columns further on.
fn overlap(first: &[f64], second: &[f64], shift: usize) -> f64 {
    first.get(shift..).map_or(0.0, |first| first.iter().zip(second).map(|(a, b)| a * b).sum())
}
