// Uniform Catmull-Clark refinement by OpenSubdiv 3.5.0 (Debian: libosd-dev), of a cage of 1024 quads to 1,048,576 in five levels.
//
//     g++ -O3 -march=native -std=c++17 benches/peers/opensubdiv.cpp -losdCPU -o /tmp/opensubdiv && /tmp/opensubdiv
//
// It reads nothing and prints JSON: seconds of the processor on one thread, the best of five, and the peak memory up to each step.
//
// The cage is closed, with a hole through it (a torus): the skin of the 12 x 12 x 12 cells without those with 4 <= i < 8 and 4 <= j < 8.
// All cells that are there, i outermost and k innermost; of each the sides whose neighbour is not there, in the order -x, +x, -y, +y, -z,
// +z; the corners of a side from the one of least coordinates, counter-clockwise as seen from outside, beginning with the step along the
// next axis (x, y, z, x) on the + sides and along the one after it on the - sides. Vertices are numbered as they first come up, and lie at
// their lattice point (x, y, z) / 12. 1024 vertices: eight of valence 3, eight of valence 5, the others of valence 4. No creases.
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/version.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <vector>

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

constexpr int CELLS = 12, LEVELS = 5, RUNS = 5;

struct Cage {
    std::vector<std::array<int, 3>> points; // of the lattice
    std::vector<int> corners;               // four a face
};
bool there(const std::array<int, 3> &c) {
    for (int x : c)
        if (x < 0 || x >= CELLS) return false;
    return !(4 <= c[0] && c[0] < 8 && 4 <= c[1] && c[1] < 8);
}
Cage make() {
    Cage cage;
    std::map<std::array<int, 3>, int> numbers;
    for (int i = 0; i < CELLS; ++i)
        for (int j = 0; j < CELLS; ++j)
            for (int k = 0; k < CELLS; ++k)
                for (int side = 0; side < 6; ++side) {
                    std::array<int, 3> cell{i, j, k}, beyond = cell;
                    int axis = side / 2, plus = side % 2;
                    beyond[axis] += plus ? 1 : -1;
                    if (!there(cell) || there(beyond)) continue;
                    int first = (axis + (plus ? 1 : 2)) % 3, second = (axis + (plus ? 2 : 1)) % 3;
                    for (int corner = 0; corner < 4; ++corner) {
                        std::array<int, 3> p = cell;
                        p[axis] += plus;
                        p[first] += corner == 1 || corner == 2;
                        p[second] += corner >= 2;
                        auto number = numbers.insert({p, int(cage.points.size())});
                        if (number.second) cage.points.push_back(p);
                        cage.corners.push_back(number.first->second);
                    }
                }
    return cage;
}

using Refiner = std::unique_ptr<Far::TopologyRefiner>;
Refiner create(const Cage &cage) {
    std::vector<int> sizes(cage.corners.size() / 4, 4);
    Far::TopologyDescriptor d;
    d.numVertices = int(cage.points.size());
    d.numFaces = int(sizes.size());
    d.numVertsPerFace = sizes.data();
    d.vertIndicesPerFace = cage.corners.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    return Refiner(Factory::Create(d, Factory::Options(Sdc::SCHEME_CATMARK, options)));
}
void refine(Far::TopologyRefiner &r, bool full) {
    Far::TopologyRefiner::UniformOptions options(LEVELS);
    options.fullTopologyInLastLevel = full; // edges and neighbours of the finest faces too, not only their vertices
    r.RefineUniform(options);
}

template <class Real> struct Point {
    Real p[3];
    void Clear() { p[0] = p[1] = p[2] = 0; }
    void AddWithWeight(const Point &other, Real w) {
        for (int k = 0; k < 3; ++k) p[k] += w * other.p[k];
    }
};
template <class Real> std::vector<Point<Real>> points(const Cage &cage, int room) {
    std::vector<Point<Real>> out(room);
    for (size_t v = 0; v < cage.points.size(); ++v)
        for (int k = 0; k < 3; ++k) out[v].p[k] = Real(cage.points[v][k]) / CELLS;
    return out;
}
template <class Real> void interpolate(const Far::TopologyRefiner &r, std::vector<Point<Real>> &all) {
    Far::PrimvarRefinerReal<Real> primvar(r);
    auto *from = all.data();
    for (int level = 1; level <= LEVELS; ++level) {
        auto *to = from + r.GetLevel(level - 1).GetNumVertices();
        primvar.Interpolate(level, from, to);
        from = to;
    }
}

double now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}
bool begun = false;
template <class Prepare, class Work> void measure(const char *name, Prepare prepare, Work work) {
    double best = 1e300;
    for (int run = 0; run < RUNS; ++run) {
        auto state = prepare();
        double start = now();
        work(state);
        best = std::min(best, now() - start);
    }
    rusage used;
    getrusage(RUSAGE_SELF, &used);
    std::printf("%s\n{\"step\":\"%s\",\"seconds\":%.4e,\"peak_mib\":%.1f}", begun ? "," : "", name, best, double(used.ru_maxrss) / 1024);
    begun = true;
}

int main() {
    Cage cage = make();
    std::map<int, int> valences, count;
    for (int v : cage.corners) ++valences[v];
    for (auto &v : valences) ++count[v.second];
    if (cage.points.size() != 1024 || cage.corners.size() != 4096 || count[3] != 8 || count[5] != 8 || count[4] != 1008) {
        std::fprintf(stderr, "this is not the cage\n");
        return 1;
    }
    auto nothing = [] { return 0; };
    std::printf("{\"version\":\"OpenSubdiv %d.%d.%d\",\"levels\":%d,\"steps\":[", OPENSUBDIV_VERSION_MAJOR, OPENSUBDIV_VERSION_MINOR,
                OPENSUBDIV_VERSION_PATCH, LEVELS);
    measure("base topology", nothing, [&](int) { create(cage); });
    measure("refine topology", [&] { return create(cage); }, [](Refiner &r) { refine(*r, false); });

    auto refined = create(cage);
    refine(*refined, false);
    int all = refined->GetNumVerticesTotal(), last = refined->GetLevel(LEVELS).GetNumVertices();
    measure("interpolate, float", [&] { return points<float>(cage, all); }, [&](auto &p) { interpolate<float>(*refined, p); });
    measure("interpolate, double", [&] { return points<double>(cage, all); }, [&](auto &p) { interpolate<double>(*refined, p); });
    auto result = points<double>(cage, all);
    interpolate<double>(*refined, result);
    double sums[3] = {0, 0, 0}, squares = 0; // over the finest vertices, to compare with
    for (int v = all - last; v < all; ++v)
        for (int k = 0; k < 3; ++k) sums[k] += result[v].p[k] / last, squares += result[v].p[k] * result[v].p[k] / last;

    measure("refine topology, full in the last level", [&] { return create(cage); }, [](Refiner &r) { refine(*r, true); });
    using Table = Far::StencilTableReal<float>;
    using Tables = Far::StencilTableFactoryReal<float>;
    Tables::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = true;
    std::unique_ptr<const Table> table;
    measure("make stencils of the last level, float", nothing, [&](int) { table.reset(Tables::Create(*refined, options)); });
    auto base = points<float>(cage, int(cage.points.size()));
    std::vector<Point<float>> out(last);
    measure("apply stencils of the last level, float", nothing, [&](int) { table->UpdateValues(base.data(), out.data()); });
    std::printf("\n],\"faces\":%d,\"vertices\":%d,\"vertices_of_all_levels\":%d,\"stencil_weights\":%zu,"
                "\"mean\":[%.15g,%.15g,%.15g],\"mean_square\":%.15g}\n",
                refined->GetLevel(LEVELS).GetNumFaces(), last, all, table->GetWeights().size(), sums[0], sums[1], sums[2], squares);
}
