//! Boxes in a tree, so that what is near to a place is found without asking all of them.

/// So many boxes or fewer are asked one by one.
const FEW: usize = 8;

/// A box: in each direction from where to where.
pub(super) type Bounds<const D: usize> = [[f64; 2]; D];

/// Boxes by where they are: halved at the median of their middles along the longest side, again and again.
pub(super) struct Tree<const D: usize> {
    /// Their numbers, those of a node side by side.
    order: Vec<u32>,
    /// A node, what is below its first half, then what is below its second.
    nodes: Vec<Node<D>>,
}

struct Node<const D: usize> {
    bounds: Bounds<D>,
    from: u32,
    to: u32,
    /// The node of the second half; 0 where there are no halves.
    second: u32,
}

/// A question to a tree: something that is least, or that is there at all.
pub(super) trait Search<const D: usize> {
    /// What nothing within a box falls below; infinite where nothing of it counts.
    fn bound(&self, bounds: &Bounds<D>) -> f64;
    /// Whether what is at least so much need not be looked at.
    fn beyond(&self, bound: f64) -> bool;
    /// Looks at a box by its number.
    fn look(&mut self, index: usize);
}

impl<const D: usize> Tree<D> {
    /// `O(n log n)`.
    pub(super) fn new(boxes: &[Bounds<D>]) -> Self {
        let mut tree = Self { order: (0..boxes.len() as u32).collect(), nodes: Vec::new() };
        if !boxes.is_empty() {
            tree.add(boxes, 0, boxes.len());
        }
        tree
    }

    fn add(&mut self, boxes: &[Bounds<D>], from: usize, to: usize) {
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; D];
        for &index in &self.order[from..to] {
            for (all, own) in bounds.iter_mut().zip(&boxes[index as usize]) {
                *all = [all[0].min(own[0]), all[1].max(own[1])];
            }
        }
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, from: from as u32, to: to as u32, second: 0 });
        if to - from <= FEW {
            return;
        }
        let length = |d: usize| bounds[d][1] - bounds[d][0];
        let along = (1..D).fold(0, |longest, d| if length(d) > length(longest) { d } else { longest });
        let middle = |index: u32| {
            let [low, high] = boxes[index as usize][along];
            0.5 * low + 0.5 * high
        };
        let half = (to - from) / 2;
        // The number decides between equals: the same tree every time.
        self.order[from..to]
            .select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        self.add(boxes, from, from + half);
        self.nodes[node].second = self.nodes.len() as u32;
        self.add(boxes, from + half, to);
    }

    /// Asks, the nearer half first.
    pub(super) fn search(&self, question: &mut impl Search<D>) {
        if let Some(root) = self.nodes.first() {
            self.descend(0, question.bound(&root.bounds), question);
        }
    }

    /// As deep as the tree, which is the logarithm of the number of boxes.
    fn descend(&self, index: usize, bound: f64, question: &mut impl Search<D>) {
        if bound == f64::INFINITY || question.beyond(bound) {
            return;
        }
        let node = &self.nodes[index];
        if node.second == 0 {
            for &item in &self.order[node.from as usize..node.to as usize] {
                question.look(item as usize);
            }
            return;
        }
        let both = [index + 1, node.second as usize].map(|k| (k, question.bound(&self.nodes[k].bounds)));
        let [first, second] = if both[1].1 < both[0].1 { [both[1], both[0]] } else { both };
        self.descend(first.0, first.1, question);
        self.descend(second.0, second.1, question);
    }
}
