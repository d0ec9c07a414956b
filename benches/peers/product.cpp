// The exact product of α and a cubic's derivative, and its integral, by OpenCASCADE 7.6 (Debian: libocct-modeling-data-dev):
// BSplCLib::FunctionMultiply, which interpolates at as many places as the space of the product has coefficients, and a running sum.
// On the inputs of benches/fine_tuning.rs.
//
//     g++ -O3 -march=native -std=c++17 -I/usr/include/opencascade benches/peers/product.cpp -lTKMath -lTKernel -o /tmp/product && /tmp/product
//
// It reads nothing and prints JSON: seconds of the processor on one thread, the median of fifteen rounds, and how far the product is from
// α C' at 997 places, in sizes of C'.
#include <BSplCLib.hxx>
#include <BSplCLib_EvaluatorFunction.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <vector>

using Numbers = std::vector<double>;

Numbers sequence(std::uint32_t x, int count) {
    Numbers out;
    for (int i = 0; i < count; i++) {
        x = x * 1664525u + 1013904223u;
        out.push_back(x / 4294967296.0);
    }
    return out;
}

// Knots of a cubic of n vertices, three at either end.
Numbers cubic(int n) {
    Numbers inner{0.0};
    for (double u : sequence(5, n - 3)) inner.push_back(inner.back() + 0.5 + u);
    Numbers knots(3, 0.0);
    for (double t : inner) knots.push_back(t / inner.back());
    knots.insert(knots.end(), 3, 1.0);
    return knots;
}

double coil(int i, int axis) {
    double r = 1.0 + 0.3 * std::sin(0.31 * i);
    return axis == 0 ? std::cos(0.05 * i) * r : axis == 1 ? std::sin(0.05 * i) * r : 0.01 * i;
}

TColStd_Array1OfReal array(const Numbers &numbers) {
    TColStd_Array1OfReal out(1, int(numbers.size()));
    for (int i = 0; i < int(numbers.size()); i++) out(i + 1) = numbers[i];
    return out;
}

struct Alpha : BSplCLib_EvaluatorFunction {
    TColStd_Array1OfReal values, knots;
    Alpha(const Numbers &v, const Numbers &k) : values(array(v)), knots(array(k)) {}
    double at(double t) const {
        double out = 0.0;
        int inside = 1;
        BSplCLib::Eval(t, false, 0, inside, 2, const_cast<TColStd_Array1OfReal &>(knots), 1, const_cast<double &>(values(1)), out);
        return out;
    }
    void Evaluate(const int, const double *, const double t, double &result, int &error) const override {
        error = 0;
        result = at(t);
    }
};

double now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main() {
    std::printf("[");
    const char *comma = "";
    for (int n : {12, 100, 1000, 10000}) {
        Numbers of_curve = cubic(n), quadratic(of_curve.begin() + 1, of_curve.end() - 1);
        Numbers slopes, factors;
        for (int i = 0; i + 1 < n; i++)
            for (int axis = 0; axis < 3; axis++)
                slopes.push_back(3.0 * (coil(i + 1, axis) - coil(i, axis)) / (of_curve[i + 4] - of_curve[i + 1]));
        for (double u : sequence(7, n - 1)) factors.push_back(0.9 + 0.2 * u);
        // Degree 4, once continuous where the factors are: each inner knot three times.
        Numbers product(5, 0.0);
        for (std::size_t k = 3; k + 3 < quadratic.size(); k++) product.insert(product.end(), 3, quadratic[k]);
        product.insert(product.end(), 5, 1.0);
        int count = int(product.size()) - 5, status = 0;
        Alpha alpha(factors, quadratic);
        TColStd_Array1OfReal knots = array(quadratic), slope = array(slopes), wanted = array(product), out(1, 3 * count);
        Numbers integral(3 * (count + 1));
        auto work = [&] {
            BSplCLib::FunctionMultiply(alpha, 2, knots, 3, slope(1), wanted, 4, out(1), status);
            for (int axis = 0; axis < 3; axis++) integral[axis] = 0.0;
            for (int i = 0; i < count; i++) {
                double w = (product[i + 5] - product[i]) / 5.0;
                for (int axis = 0; axis < 3; axis++)
                    integral[3 * (i + 1) + axis] = integral[3 * i + axis] + w * out(3 * i + axis + 1);
            }
        };
        work();
        int often = std::max(1, 20000 / n);
        Numbers rounds;
        for (int round = 0; round < 15; round++) {
            double start = now();
            for (int i = 0; i < often; i++) work();
            rounds.push_back((now() - start) / often);
        }
        std::sort(rounds.begin(), rounds.end());
        double off = 0.0, size = 0.0;
        for (int s = 0; s < 997; s++) {
            double t = (s + 0.41) / 997.0, a = alpha.at(t), exact[3], ours[3];
            int inside = 1;
            BSplCLib::Eval(t, false, 0, inside, 2, knots, 3, slope(1), exact[0]);
            BSplCLib::Eval(t, false, 0, inside, 4, wanted, 3, out(1), ours[0]);
            for (int axis = 0; axis < 3; axis++) {
                off = std::max(off, std::abs(a * exact[axis] - ours[axis]));
                size = std::max(size, std::abs(exact[axis]));
            }
        }
        std::printf("%s{\"n\": %d, \"status\": %d, \"seconds\": %.6e, \"off\": %.3e}", comma, n, status, rounds[7], off / size);
        comma = ", ";
        std::fflush(stdout);
    }
    std::printf("]\n");
}
