// Makes opensubdiv.json: limits and refined points of 200 small Catmull-Clark cages by OpenSubdiv 3.5.0 (Debian: libosd-dev).
//
//     g++ -O2 -std=c++17 tests/golden/opensubdiv.cpp -losdCPU -o /tmp/opensubdiv && /tmp/opensubdiv > tests/golden/opensubdiv.json
//
// It reads nothing and draws from a generator of its own: the same bytes at every run. On stderr it says what it covered.
//
// A cage is refined uniformly in double precision until no finite sharpness is left ("levels", at least once), with the rows of the
// identity matrix as points, so that each point is its own stencil over the cage. At the vertex that a vertex of the cage has become,
// OpenSubdiv's limit masks give the position and two tangents.
//
// They are held against OpenSubdiv itself. Its masks one level further down have to say the same, tangents up to a factor. And the ring
// around the vertex is made a mesh of its own and refined once, which gives the matrix that takes a ring to the next; its powers
// converge to the position's weights, and without these to tangents. The masks disagree with that, and what the powers give is written
// instead ("by", "tangents_by": "powers"),
//   - at ends of creases of infinite sharpness (darts), where the masks are those of a smooth vertex: position and both tangents;
//   - at inner smooth vertices of two faces, where the mask is the vertex itself: the position. There are no tangents at these, nor at
//     darts of two faces, as there is no plane;
//   - where more than two faces lie to the side of a crease or boundary: the second tangent, whose mask is that of Biermann, Levin and
//     Zorin's modified rules, which OpenSubdiv does not refine by.
//
// Finite sharpnesses are whole in a cage, or n + 15 k / 64 with k in 1..4: then the means that OpenSubdiv takes of fractions in single
// precision come out exactly where 1 to 6 of them meet, and nothing is rounded to seven digits.
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

constexpr int MOST = 32; // vertices of a cage
constexpr int CAGES = 200, LIMITS = 5;
constexpr float INFINITELY = 10.0f;

using Point = std::array<double, 3>;
using Faces = std::vector<std::vector<int>>;
using Edge = std::pair<int, int>;

struct Mesh {
    std::string name;
    std::vector<Point> points;
    Faces faces;
};
struct Cage : Mesh {
    bool corners_kept = false;
    std::map<Edge, float> creases;
    std::map<int, float> corners;
};

[[noreturn]] void stop(const std::string &why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    std::exit(1);
}

// ---- chance -------------------------------------------------------------------------------------------------------------------------
uint64_t state = 20261122;
uint32_t draw() {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return uint32_t(state >> 33);
}
int below(int n) { return int(draw() % uint32_t(n)); }

// ---- topology -----------------------------------------------------------------------------------------------------------------------
Edge undirected(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

// The faces left of the directed edges; empty if two share one.
std::map<Edge, int> sides(const Faces &faces) {
    std::map<Edge, int> out;
    for (size_t f = 0; f < faces.size(); ++f)
        for (size_t i = 0; i < faces[f].size(); ++i)
            if (!out.insert({{faces[f][i], faces[f][(i + 1) % faces[f].size()]}, int(f)}).second) return {};
    return out;
}
std::vector<Edge> edges(const Faces &faces) {
    std::set<Edge> out;
    for (auto &side : sides(faces)) out.insert(undirected(side.first.first, side.first.second));
    return {out.begin(), out.end()};
}
// Around each vertex: for every corner of a face the next vertex to the previous one.
std::vector<std::map<int, int>> turns(const Mesh &m) {
    std::vector<std::map<int, int>> out(m.points.size());
    for (auto &f : m.faces)
        for (size_t i = 0; i < f.size(); ++i) out[f[i]][f[(i + 1) % f.size()]] = f[(i + f.size() - 1) % f.size()];
    return out;
}
// Consistently oriented, no edge of three faces or more, all vertices in use, one fan each, no face with a vertex twice.
bool sound(const Mesh &m) {
    if (m.faces.empty() || sides(m.faces).empty()) return false;
    for (auto &f : m.faces)
        if (f.size() < 3 || std::set<int>(f.begin(), f.end()).size() != f.size()) return false;
    std::vector<int> corners(m.points.size());
    for (auto &f : m.faces)
        for (int v : f) ++corners[v];
    auto around = turns(m);
    for (size_t v = 0; v < m.points.size(); ++v) {
        if (around[v].empty() || int(around[v].size()) != corners[v]) return false;
        std::set<int> reached;
        for (auto &turn : around[v]) reached.insert(turn.second);
        std::vector<int> starts;
        for (auto &turn : around[v])
            if (!reached.count(turn.first)) starts.push_back(turn.first);
        if (starts.size() > 1) return false;
        int at = starts.empty() ? around[v].begin()->first : starts[0];
        size_t seen = 0;
        for (auto next = around[v].find(at); next != around[v].end() && seen < around[v].size(); next = around[v].find(at)) {
            at = next->second;
            ++seen;
            if (starts.empty() && at == around[v].begin()->first) break;
        }
        if (seen != around[v].size()) return false;
    }
    return true;
}
// Leaves out vertices that no face uses.
void compact(Mesh &m) {
    std::vector<int> to(m.points.size(), -1);
    for (auto &f : m.faces)
        for (int v : f) to[v] = 0;
    std::vector<Point> points;
    for (size_t v = 0; v < to.size(); ++v)
        if (to[v] == 0) to[v] = int(points.size()), points.push_back(m.points[v]);
    for (auto &f : m.faces)
        for (int &v : f) v = to[v];
    m.points = points;
}

// ---- cages --------------------------------------------------------------------------------------------------------------------------
double short_number(double x) { return std::round(x * 64) / 64; }
Point on_circle(int i, int k, double radius, double z) {
    double a = 2 * M_PI * i / k;
    return {radius * std::cos(a), radius * std::sin(a), z};
}
Mesh pyramid(int k) {
    Mesh m{"pyramid " + std::to_string(k), {}, {{}}};
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, 0)), m.faces[0].insert(m.faces[0].begin(), i);
    m.points.push_back({0, 0, 1});
    for (int i = 0; i < k; ++i) m.faces.push_back({i, (i + 1) % k, k});
    return m;
}
Mesh bipyramid(int k) {
    Mesh m{"bipyramid " + std::to_string(k), {}, {}};
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, 0));
    m.points.push_back({0, 0, 1});
    m.points.push_back({0, 0, -1});
    for (int i = 0; i < k; ++i) m.faces.push_back({i, (i + 1) % k, k}), m.faces.push_back({(i + 1) % k, i, k + 1});
    return m;
}
Mesh prism(int k) {
    Mesh m{"prism " + std::to_string(k), {}, {{}, {}}};
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, -1)), m.faces[0].insert(m.faces[0].begin(), i);
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, 1)), m.faces[1].push_back(k + i);
    for (int i = 0; i < k; ++i) m.faces.push_back({i, (i + 1) % k, k + (i + 1) % k, k + i});
    return m;
}
Mesh antiprism(int k) {
    Mesh m{"antiprism " + std::to_string(k), {}, {{}, {}}};
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(2 * i, 2 * k, 1, -1)), m.faces[0].insert(m.faces[0].begin(), i);
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(2 * i + 1, 2 * k, 1, 1)), m.faces[1].push_back(k + i);
    for (int i = 0; i < k; ++i) m.faces.push_back({i, (i + 1) % k, k + i}), m.faces.push_back({k + i, (i + 1) % k, k + (i + 1) % k});
    return m;
}
Mesh polygon(int k) {
    Mesh m{"polygon " + std::to_string(k), {}, {{}}};
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, 0)), m.faces[0].push_back(i);
    return m;
}
Mesh pillow(int k) {
    Mesh m = polygon(k);
    m.name = "pillow " + std::to_string(k);
    m.faces.push_back({m.faces[0].rbegin(), m.faces[0].rend()});
    return m;
}
Mesh quads_around(int k) {
    Mesh m{std::to_string(k) + " quads", {{0, 0, 0.5}}, {}};
    for (int i = 0; i < 2 * k; ++i) m.points.push_back(on_circle(i, 2 * k, i % 2 ? 1.5 : 1, 0));
    for (int i = 0; i < k; ++i) m.faces.push_back({0, 1 + 2 * i, 2 + 2 * i, 1 + (2 * i + 2) % (2 * k)});
    return m;
}
Mesh triangles_around(int k) {
    Mesh m{std::to_string(k) + " triangles", {{0, 0, 0.5}}, {}};
    for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, 0));
    for (int i = 0; i < k; ++i) m.faces.push_back({0, 1 + i, 1 + (i + 1) % k});
    return m;
}
// Half of a wheel: k faces around a vertex of the boundary.
Mesh fan(int k, bool quads) {
    Mesh m{"fan of " + std::to_string(k) + (quads ? " quads" : " triangles"), {{0, 0, 0}}, {}};
    int per = quads ? 2 : 1;
    for (int i = 0; i <= per * k; ++i) m.points.push_back(on_circle(i, 2 * per * k, quads && i % 2 ? 1.5 : 1, 0.125 * (i % 3)));
    for (int i = 0; i < k; ++i)
        if (quads) m.faces.push_back({0, 1 + 2 * i, 2 + 2 * i, 3 + 2 * i});
        else m.faces.push_back({0, 1 + i, 2 + i});
    return m;
}
Mesh grid(int columns, int rows) {
    Mesh m{"grid " + std::to_string(columns) + "x" + std::to_string(rows), {}, {}};
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) m.points.push_back({double(i), double(j), 0});
    int w = columns + 1;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) m.faces.push_back({j * w + i, j * w + i + 1, j * w + w + i + 1, j * w + w + i});
    return m;
}
// A closed ring of quads: a torus of a by b.
Mesh torus(int a, int b) {
    Mesh m{"torus " + std::to_string(a) + "x" + std::to_string(b), {}, {}};
    for (int i = 0; i < a; ++i)
        for (int j = 0; j < b; ++j) {
            Point p = on_circle(j, b, 0.5, 0);
            Point q = on_circle(i, a, 1.25 + p[0], p[1]);
            m.points.push_back(q);
        }
    for (int i = 0; i < a; ++i)
        for (int j = 0; j < b; ++j) {
            int i1 = (i + 1) % a, j1 = (j + 1) % b;
            m.faces.push_back({i * b + j, i1 * b + j, i1 * b + j1, i * b + j1});
        }
    return m;
}
// A tube open at both ends.
Mesh tube(int k, int rows) {
    Mesh m{"tube " + std::to_string(k) + "x" + std::to_string(rows), {}, {}};
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i < k; ++i) m.points.push_back(on_circle(i, k, 1, j));
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < k; ++i) m.faces.push_back({j * k + i, j * k + (i + 1) % k, (j + 1) * k + (i + 1) % k, (j + 1) * k + i});
    return m;
}
Point middle(const Mesh &m, const std::vector<int> &of) {
    Point p{0, 0, 0};
    for (int v : of)
        for (int k = 0; k < 3; ++k) p[k] += m.points[v][k] / double(of.size());
    return p;
}
// The faces around a vertex of a closed mesh, in order.
std::vector<int> faces_around(const Mesh &m, int v) {
    auto side = sides(m.faces);
    auto around = turns(m)[v];
    std::vector<int> out;
    int at = around.begin()->first;
    for (size_t i = 0; i < around.size(); ++i) out.push_back(side[{v, at}]), at = around[at];
    return out;
}
Mesh dual(const Mesh &m) {
    Mesh out{"dual of " + m.name, {}, {}};
    for (auto &f : m.faces) out.points.push_back(middle(m, f));
    for (size_t v = 0; v < m.points.size(); ++v) out.faces.push_back(faces_around(m, int(v)));
    return out;
}
Mesh ambo(const Mesh &m) {
    Mesh out{"ambo of " + m.name, {}, {}};
    std::map<Edge, int> at;
    for (auto &e : edges(m.faces)) at[e] = int(out.points.size()), out.points.push_back(middle(m, {e.first, e.second}));
    for (auto &f : m.faces) {
        out.faces.emplace_back();
        for (size_t i = 0; i < f.size(); ++i) out.faces.back().push_back(at[undirected(f[i], f[(i + 1) % f.size()])]);
    }
    auto around = turns(m);
    for (size_t v = 0; v < m.points.size(); ++v) {
        out.faces.emplace_back();
        int to = around[v].begin()->first;
        for (size_t i = 0; i < around[v].size(); ++i) out.faces.back().push_back(at[undirected(int(v), to)]), to = around[v][to];
    }
    return out;
}
Mesh kis(const Mesh &m, size_t few = 1000) {
    Mesh out{"kis of " + m.name, m.points, {}};
    for (size_t n = 0; n < m.faces.size(); ++n) {
        auto &f = m.faces[n];
        if (n >= few) { out.faces.push_back(f); continue; }
        for (size_t i = 0; i < f.size(); ++i) out.faces.push_back({f[i], f[(i + 1) % f.size()], int(out.points.size())});
        out.points.push_back(middle(m, f));
    }
    return out;
}
// A quad for each edge, between its ends and the middles of its faces.
Mesh join(const Mesh &m) {
    Mesh out{"join of " + m.name, m.points, {}};
    for (auto &f : m.faces) out.points.push_back(middle(m, f));
    int n = int(m.points.size());
    auto side = sides(m.faces);
    for (auto &e : edges(m.faces)) out.faces.push_back({e.first, n + side[{e.second, e.first}], e.second, n + side[e]});
    return out;
}
// A face becomes a smaller one, lifted, and quads around it.
void extrude(Mesh &m, int face) {
    auto outer = m.faces[face];
    Point c = middle(m, outer);
    std::vector<int> inner;
    for (int v : outer) {
        Point p = m.points[v];
        for (int k = 0; k < 3; ++k) p[k] = 0.5 * p[k] + 0.5 * c[k] + 0.75 * c[k];
        inner.push_back(int(m.points.size()));
        m.points.push_back(p);
    }
    m.faces[face] = inner;
    for (size_t i = 0; i < outer.size(); ++i) {
        size_t j = (i + 1) % outer.size();
        m.faces.push_back({outer[i], outer[j], inner[j], inner[i]});
    }
    m.name += ", extruded";
}
// Two faces that share an edge become one; false, and nothing changes, where that is no sound mesh or larger than a heptagon.
bool merge(Mesh &m, Edge e) {
    auto side = sides(m.faces);
    auto a = side.find(e), b = side.find({e.second, e.first});
    if (a == side.end() || b == side.end() || a->second == b->second) return false;
    Mesh out = m;
    auto f = m.faces[a->second], g = m.faces[b->second];
    std::rotate(f.begin(), std::find(f.begin(), f.end(), e.second), f.end()); // second … first
    std::rotate(g.begin(), std::find(g.begin(), g.end(), e.first), g.end());  // first … second
    f.insert(f.end(), g.begin() + 1, g.end() - 1);
    if (f.size() > 7) return false;
    out.faces[a->second] = f;
    out.faces.erase(out.faces.begin() + b->second);
    if (!sound(out)) return false;
    m = out;
    return true;
}
void merge_some(Mesh &m, int tries) {
    for (int i = 0; i < tries; ++i) {
        auto all = edges(m.faces);
        merge(m, all[below(int(all.size()))]);
    }
    m.name += ", merged";
}
bool remove_face(Mesh &m, int face) {
    Mesh out = m;
    out.faces.erase(out.faces.begin() + face);
    compact(out);
    if (!sound(out)) return false;
    m = out;
    return true;
}
void open_up(Mesh &m, int tries) {
    for (int i = 0; i < tries; ++i) remove_face(m, below(int(m.faces.size())));
    m.name += ", opened";
}
// A vertex of two faces in the middle of an edge.
void split_edge(Mesh &m, Edge e) {
    int v = int(m.points.size());
    m.points.push_back(middle(m, {e.first, e.second}));
    for (auto &f : m.faces)
        for (size_t i = 0; i < f.size(); ++i)
            if (undirected(f[i], f[(i + 1) % f.size()]) == e) {
                f.insert(f.begin() + i + 1, v);
                break;
            }
    m.name += ", an edge split";
}
Mesh random_triangles(int n) {
    Mesh m = bipyramid(3);
    while (int(m.points.size()) < n) {
        int face = below(int(m.faces.size())), v = int(m.points.size());
        auto f = m.faces[face];
        Point p = middle(m, f);
        for (int k = 0; k < 3; ++k) p[k] *= 1.75;
        m.points.push_back(p);
        m.faces[face] = {f[0], f[1], v};
        m.faces.push_back({f[1], f[2], v});
        m.faces.push_back({f[2], f[0], v});
    }
    for (int i = 0; i < 4 * n; ++i) { // flips of edges
        auto all = edges(m.faces);
        Edge e = all[below(int(all.size()))];
        auto side = sides(m.faces);
        int a = side[e], b = side[{e.second, e.first}], to = -1, from = -1;
        for (int v : m.faces[a]) if (v != e.first && v != e.second) to = v;
        for (int v : m.faces[b]) if (v != e.first && v != e.second) from = v;
        if (to == from || std::count(all.begin(), all.end(), undirected(to, from))) continue;
        m.faces[a] = {e.first, from, to};
        m.faces[b] = {from, e.second, to};
    }
    m.name = "random triangles " + std::to_string(n);
    return m;
}
Mesh make(int n) {
    int round = n / 20;
    Mesh m;
    switch (n % 20) {
    case 0: return round < 5 ? pyramid(3 + round) : bipyramid(round);
    case 1: return round < 6 ? bipyramid(5 + round) : antiprism(round - 3);
    case 2: return round < 5 ? prism(3 + round) : pillow(round - 2);
    case 3: return quads_around(3 + round % 8);
    case 4: return triangles_around(3 + (round + 3) % 8);
    case 5: return fan(1 + round % 9, true);
    case 6: return fan(1 + (round + 4) % 9, false);
    case 7: return round < 5 ? polygon(3 + round) : grid(round - 4, 2);
    case 8: m = grid(4, 3); m.faces.erase(m.faces.begin() + (round % 3 == 0 ? 5 : round % 3 == 1 ? 6 : 1)); compact(m);
            m.name += ", a face less"; return m;
    case 9: m = grid(3 + round % 2, 3); merge_some(m, 4 + round); return m;
    case 10: m = prism(4); for (int i = 0; i < 1 + round % 3; ++i) extrude(m, below(6)); return m;
    case 11: return random_triangles(6 + round);
    case 12: m = random_triangles(9 + round); merge_some(m, 6 + 2 * round); return m;
    case 13: return join(random_triangles(5 + round % 4));
    case 14: m = random_triangles(8 + round); open_up(m, 1 + round % 4); return m;
    case 15: m = join(random_triangles(6 + round % 3)); open_up(m, 2 + round % 3); return m;
    case 16: m = round % 2 ? antiprism(3 + round / 2) : prism(3 + round / 2); return round % 4 < 2 ? dual(m) : ambo(pyramid(3 + round / 2));
    case 17: return round % 2 ? kis(prism(3 + round / 2), round % 4 == 1 ? 2 : 1000) : kis(pyramid(3 + round / 2), 1);
    case 18: return round % 2 ? torus(3 + round / 4, 4 + round % 3) : tube(3 + round / 2, 2);
    default: m = round % 2 ? prism(3 + round / 3) : round % 4 ? grid(3, 3) : random_triangles(8);
             for (int i = 0; i < 1 + round % 3; ++i) { auto all = edges(m.faces); split_edge(m, all[below(int(all.size()))]); }
             if (round >= 7) merge_some(m, 3);
             return m;
    }
}

// ---- creases ------------------------------------------------------------------------------------------------------------------------
struct Sharpnesses {
    bool whole;
    float one() const { return whole ? float(1 + below(4)) : float(below(5)) + 15.0f * float(1 + below(4)) / 64.0f; }
};
float capped(float s) { return std::min(s, 4.703125f); }

void sharpen(Cage &c, int pattern) {
    Sharpnesses chance{pattern % 2 == 0};
    auto all = edges(c.faces);
    auto side = sides(c.faces);
    std::vector<std::vector<int>> next(c.points.size());
    std::vector<Edge> inner;
    for (auto &e : all) {
        next[e.first].push_back(e.second), next[e.second].push_back(e.first);
        if (side.count(e) && side.count({e.second, e.first})) inner.push_back(e);
    }
    std::set<int> rim;
    for (auto &e : all)
        if (!(side.count(e) && side.count({e.second, e.first}))) rim.insert(e.first), rim.insert(e.second);
    auto path = [&](int length, float s) { // along inner edges, no vertex twice
        std::vector<int> starts;
        for (int v = 0; v < int(c.points.size()); ++v)
            if (!rim.count(v)) starts.push_back(v);
        if (starts.empty()) return;
        int at = starts[below(int(starts.size()))];
        std::set<int> seen{at};
        for (int i = 0; i < length; ++i) {
            std::vector<int> to;
            for (int v : next[at])
                if (!seen.count(v) && std::count(inner.begin(), inner.end(), undirected(at, v))) to.push_back(v);
            if (to.empty()) break;
            int v = to[below(int(to.size()))];
            c.creases[undirected(at, v)] = s;
            seen.insert(v);
            at = v;
        }
    };
    auto loop = [&](std::function<float()> s) { // around a face
        auto &f = c.faces[below(int(c.faces.size()))];
        for (size_t i = 0; i < f.size(); ++i) c.creases[undirected(f[i], f[(i + 1) % f.size()])] = s();
    };
    auto meeting = [&](int count, std::function<float()> s) { // creases at the vertex of most edges
        int best = 0;
        for (int v = 1; v < int(c.points.size()); ++v)
            if (next[v].size() > next[best].size()) best = v;
        auto to = next[best];
        int skip = below(int(to.size()));
        for (int i = 0; i < count && i < int(to.size()); ++i)
            c.creases[undirected(best, to[(skip + i * std::max(1, int(to.size()) / count)) % to.size()])] = s();
    };
    auto some = [&](double share, std::function<float()> s) {
        for (auto &e : all)
            if (draw() % 1024 < share * 1024) c.creases[e] = s();
    };
    auto any_vertex = [&] { return below(int(c.points.size())); };
    auto endless = [] { return INFINITELY; };
    auto finite = [&] { return capped(chance.one()); };
    switch (pattern) {
    case 0: case 1: break;
    case 2: case 3: some(0.25, finite); break;
    case 4: loop(endless); break;
    case 5: path(1 + below(3), INFINITELY); break;
    case 6: meeting(3, endless); break;
    case 7: c.corners[any_vertex()] = INFINITELY; c.corners[any_vertex()] = finite(); some(0.1, finite); break;
    case 8: loop(finite); c.corners[any_vertex()] = finite(); break;
    case 9: path(2 + below(2), INFINITELY); some(0.15, finite); break;
    case 10: meeting(3, finite); path(1 + below(2), finite()); break;
    case 11: some(0.2, endless); some(0.2, finite); c.corners[any_vertex()] = finite(); break;
    case 12: { float s = finite(); loop([=] { return s; }); path(2, finite()); break; }
    case 13: loop(endless); loop(finite); c.corners[any_vertex()] = INFINITELY; break;
    case 14: meeting(2, endless); break;
    default: meeting(2, finite); meeting(2, endless); c.corners[any_vertex()] = finite(); break;
    }
    std::vector<int> met(c.points.size()); // more than six fractions at a vertex would be rounded
    for (auto crease = c.creases.begin(); crease != c.creases.end();) {
        if (crease->second < INFINITELY && (met[crease->first.first] == 5 || met[crease->first.second] == 5)) {
            crease = c.creases.erase(crease);
            continue;
        }
        ++met[crease->first.first], ++met[crease->first.second];
        ++crease;
    }
}

// ---- OpenSubdiv ---------------------------------------------------------------------------------------------------------------------
struct Row {
    double w[MOST];
    void Clear() { std::fill(w, w + MOST, 0.0); }
    void AddWithWeight(const Row &other, double s) {
        for (int i = 0; i < MOST; ++i) w[i] += s * other.w[i];
    }
};
struct Position {
    Point p;
    void Clear() { p = {0, 0, 0}; }
    void AddWithWeight(const Position &other, double s) {
        for (int i = 0; i < 3; ++i) p[i] += s * other.p[i];
    }
};
using Refiner = std::unique_ptr<Far::TopologyRefiner>;

Refiner refiner(const Faces &faces, int vertices, bool corners_kept, const std::map<Edge, float> &creases,
                const std::map<int, float> &corners) {
    std::vector<int> sizes, indices, pairs, at;
    std::vector<float> edge_sharpness, vertex_sharpness;
    for (auto &f : faces) sizes.push_back(int(f.size())), indices.insert(indices.end(), f.begin(), f.end());
    for (auto &crease : creases)
        pairs.push_back(crease.first.first), pairs.push_back(crease.first.second), edge_sharpness.push_back(crease.second);
    for (auto &corner : corners) at.push_back(corner.first), vertex_sharpness.push_back(corner.second);
    Far::TopologyDescriptor d;
    d.numVertices = vertices;
    d.numFaces = int(sizes.size());
    d.numVertsPerFace = sizes.data();
    d.vertIndicesPerFace = indices.data();
    d.numCreases = int(edge_sharpness.size());
    d.creaseVertexIndexPairs = pairs.data();
    d.creaseWeights = edge_sharpness.data();
    d.numCorners = int(at.size());
    d.cornerVertexIndices = at.data();
    d.cornerWeights = vertex_sharpness.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(corners_kept ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    options.SetCreasingMethod(Sdc::Options::CREASE_UNIFORM);
    options.SetTriangleSubdivision(Sdc::Options::TRI_SUB_CATMARK);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Factory::Options how(Sdc::SCHEME_CATMARK, options);
    how.validateFullTopology = true;
    return Refiner(Factory::Create(d, how));
}
void refine(Far::TopologyRefiner &r, int levels) {
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = true;
    r.RefineUniform(options);
}
std::vector<Row> identity(int n) {
    std::vector<Row> out(n);
    for (int i = 0; i < n; ++i) out[i].Clear(), out[i].w[i] = 1;
    return out;
}
struct Limit {
    Row position, first, second;
    Sdc::Crease::Rule rule;
};
// Limits at all vertices of a cage, from the masks at a level; and the rows of all points of that level.
std::vector<Limit> limits(const Cage &c, int levels, Refiner &r, std::vector<Row> &rows, std::vector<int> &became) {
    int n = int(c.points.size());
    r = refiner(c.faces, n, c.corners_kept, c.creases, c.corners);
    if (!r) return {};
    refine(*r, levels);
    Far::PrimvarRefinerReal<double> primvar(*r);
    rows = identity(n);
    became.resize(n);
    for (int v = 0; v < n; ++v) became[v] = v;
    for (int level = 1; level <= levels; ++level) {
        std::vector<Row> next(r->GetLevel(level).GetNumVertices());
        primvar.Interpolate(level, rows, next);
        for (int &v : became) v = r->GetLevel(level - 1).GetVertexChildVertex(v);
        rows.swap(next);
    }
    std::vector<Row> position(rows.size()), first(rows.size()), second(rows.size());
    primvar.Limit(rows, position, first, second);
    std::vector<Limit> out;
    for (int v : became) out.push_back({position[v], first[v], second[v], r->GetLevel(levels).GetVertexRule(v)});
    return out;
}
// A ring around a vertex as a mesh of its own, and the matrix that takes it to the next ring.
struct Ring {
    std::vector<int> global;                // the vertices of the level; the first is the one in the middle
    std::map<int, int> local;               // and back
    std::vector<std::vector<double>> next;  // next ring = next * ring
    std::vector<double> position;           // the limit's weights: the left eigenvector of 1
};
using Weights = std::vector<double>;

// Of the ring's faces and spokes those from `first` on, `faces` and `spokes` of them.
Ring ring(const Far::TopologyLevel &level, int v, int first, int spokes, int faces, bool corners_kept) {
    Ring out;
    auto enter = [&](int g) {
        if (out.local.insert({g, int(out.global.size())}).second) out.global.push_back(g);
        return out.local[g];
    };
    enter(v);
    bool all = spokes == level.GetVertexEdges(v).size();
    std::map<Edge, float> creases;
    std::map<int, float> corners;
    if (level.GetVertexSharpness(v) > 0) corners[0] = level.GetVertexSharpness(v);
    for (int i = 0; i < spokes; ++i) {
        int e = level.GetVertexEdges(v)[first + i];
        auto ends = level.GetEdgeVertices(e);
        int other = enter(ends[0] == v ? ends[1] : ends[0]);
        if (level.GetEdgeSharpness(e) > 0) creases[{0, other}] = level.GetEdgeSharpness(e);
    }
    Faces quads;
    for (int i = 0; i < faces; ++i) {
        quads.emplace_back();
        for (int g : level.GetFaceVertices(level.GetVertexFaces(v)[first + i])) quads.back().push_back(enter(g));
    }
    int n = int(out.global.size());
    if (n != 1 + spokes + faces || n > MOST) stop("a ring is no ring");
    auto r = refiner(quads, n, all && corners_kept, creases, corners);
    refine(*r, 1);
    std::vector<Row> rows(r->GetLevel(1).GetNumVertices());
    Far::PrimvarRefinerReal<double>(*r).Interpolate(1, identity(n), rows);
    auto &base = r->GetLevel(0);
    out.next.resize(n);
    auto take = [&](int at, int child) { out.next[at].assign(rows[child].w, rows[child].w + n); };
    take(0, base.GetVertexChildVertex(0));
    for (int e : base.GetVertexEdges(0)) {
        auto ends = base.GetEdgeVertices(e);
        take(ends[0] == 0 ? ends[1] : ends[0], base.GetEdgeChildVertex(e));
    }
    for (int f : base.GetVertexFaces(0)) {
        auto corners_of = base.GetFaceVertices(f);
        for (int i = 0; i < 4; ++i)
            if (corners_of[i] == 0) take(corners_of[(i + 2) % 4], base.GetFaceChildVertex(f));
    }
    auto m = out.next;
    for (int square = 0; square < 9; ++square) { // the 512th power: what is below the first eigenvalue is at most 0.7 of it
        std::vector<Weights> s(n, Weights(n));
        for (int i = 0; i < n; ++i) {
            double sum = 0;
            for (int k = 0; k < n; ++k)
                for (int j = 0; j < n; ++j) s[i][j] += m[i][k] * m[k][j];
            for (double x : s[i]) sum += x;
            for (double &x : s[i]) x /= sum; // rows sum to 1
        }
        m.swap(s);
    }
    out.position = m[0];
    return out;
}
Row expand(const Ring &ring, const Weights &w, const std::vector<Row> &rows) {
    Row out;
    out.Clear();
    for (size_t k = 0; k < w.size(); ++k) out.AddWithWeight(rows[ring.global[k]], w[k]);
    return out;
}
// The left eigenvector of the largest eigenvalue but 1 that the powers find from a start; empty if they find none. The start is even or
// odd under the ring's reflection, as the matrix is, and so is what is found.
Weights tangent(const Ring &ring, Weights x) {
    size_t n = x.size();
    for (int step = 0; step < 2000; ++step) {
        double sum = 0, size = 0, change = 0, dot = 0;
        for (double w : x) sum += w;
        for (size_t i = 0; i < n; ++i) x[i] -= sum * ring.position[i]; // without the eigenvector of 1
        for (double w : x) size = std::max(size, std::abs(w));
        for (double &w : x) w /= size;
        Weights y(n);
        for (size_t i = 0; i < n; ++i)
            for (size_t j = 0; j < n; ++j) y[j] += x[i] * ring.next[i][j];
        double xx = 0;
        for (size_t i = 0; i < n; ++i) dot += x[i] * y[i], xx += x[i] * x[i];
        for (size_t i = 0; i < n; ++i) change = std::max(change, std::abs(y[i] - dot / xx * x[i]));
        if (change <= 3e-16) return x;
        if (step == 1999 && change <= 2e-14) return x;
        x = y;
    }
    return {};
}
int far_end(const Far::TopologyLevel &level, int v, int spoke) {
    auto ends = level.GetEdgeVertices(level.GetVertexEdges(v)[spoke]);
    return ends[0] == v ? ends[1] : ends[0];
}
int opposite(const Far::TopologyLevel &level, int v, int sector) {
    return level.GetFaceVertices(level.GetVertexFaces(v)[sector])[(level.GetVertexFaceLocalIndices(v)[sector] + 2) % 4];
}

double apart(const Row &a, const Row &b, double factor = 1) {
    double most = 0;
    for (int i = 0; i < MOST; ++i) most = std::max(most, std::abs(a.w[i] - factor * b.w[i]));
    return most;
}
double largest(const Row &a) { return apart(a, a, 0); }
// Whether two rows are the same up to a positive factor.
bool parallel(const Row &a, const Row &b) {
    double ab = 0, bb = 0;
    for (int i = 0; i < MOST; ++i) ab += a.w[i] * b.w[i], bb += b.w[i] * b.w[i];
    return ab > 0 && apart(a, b, ab / bb) <= 1e-11 * largest(a);
}
double sum(const Row &a) {
    double s = 0;
    for (double x : a.w) s += x;
    return s;
}

// ---- writing ------------------------------------------------------------------------------------------------------------------------
// The shortest of up to 17 significant digits that reads back as the same number.
std::string number(double x) {
    if (x == std::round(x) && std::abs(x) < 1e6) return std::to_string(int(x));
    char text[40];
    for (int digits = 1; digits <= 17; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, x);
        if (std::strtod(text, nullptr) == x) break;
    }
    return text;
}
template <class Items, class Write> std::string list(const Items &items, Write write) {
    std::string out = "[";
    for (auto &item : items) out += (out.size() > 1 ? "," : "") + write(item);
    return out + "]";
}
std::string whole(int i) { return std::to_string(i); }
std::string point(const Point &p) { return list(p, number); }
std::string face(const std::vector<int> &f) { return list(f, whole); }
std::string stencil(const Row &row) {
    std::vector<std::pair<int, double>> entries;
    for (int i = 0; i < MOST; ++i)
        if (std::abs(row.w[i]) >= 1e-17) entries.push_back({i, row.w[i]});
    return list(entries, [](auto &e) { return "[" + whole(e.first) + "," + number(e.second) + "]"; });
}

int main() {
    std::printf("{\"what\":\"limit stencils and refined points of Catmull-Clark cages\",\"version\":\"OpenSubdiv %d.%d.%d\",\"cages\":[",
                OPENSUBDIV_VERSION_MAJOR, OPENSUBDIV_VERSION_MINOR, OPENSUBDIV_VERSION_PATCH);
    std::map<std::string, int> count;
    double worst_sum = 0, worst_slope = 0, worst_masks = 0, worst_powers = 0;
    for (int n = 0; n < CAGES; ++n) {
        Cage c;
        static_cast<Mesh &>(c) = make(n);
        if (!sound(c)) stop(c.name + ": no manifold");
        if (c.points.size() > MOST) stop(c.name + ": too large");
        for (auto &p : c.points)
            for (double &x : p) x = short_number(x + (below(33) - 16) / 128.0);
        c.corners_kept = (n / 3 + n / 20) % 2;
        int pattern = (7 * n + 3 * (n / 20)) % 16;
        sharpen(c, pattern);
        float most = 0;
        for (auto &crease : c.creases) if (crease.second < INFINITELY) most = std::max(most, crease.second);
        for (auto &corner : c.corners) if (corner.second < INFINITELY) most = std::max(most, corner.second);
        int levels = std::max(1, int(std::ceil(most)));

        Refiner r, further;
        std::vector<Row> rows, more;
        std::vector<int> became, later;
        auto here = limits(c, levels, r, rows, became);
        if (here.empty()) stop(c.name + ": OpenSubdiv refuses it");
        auto deeper = limits(c, levels + 1, further, more, later);

        // The most telling vertices: one of each kind first.
        auto &base = r->GetLevel(0);
        std::vector<std::array<int, 3>> order;
        std::map<std::string, int> seen;
        std::vector<std::string> kinds;
        for (int v = 0; v < int(c.points.size()); ++v) {
            int edge_count = base.GetVertexEdges(v).size(), face_count = base.GetVertexFaces(v).size();
            bool rim = edge_count != face_count;
            auto at_first = base.GetVertexRule(v), at_last = here[v].rule;
            bool plain = at_first == Sdc::Crease::RULE_SMOOTH;
            std::string kind = whole(at_first) + " " + whole(at_last) + (rim ? " rim " : " inner ") + whole(face_count);
            kinds.push_back(kind);
            int score = (at_last == Sdc::Crease::RULE_DART ? 6 : 0) + (at_first != at_last ? 4 : 0) + (plain ? 0 : 3) + (rim ? 1 : 0) +
                        (face_count == (rim ? 2 : 4) ? 0 : 2);
            order.push_back({-(score - 10 * seen[kind]++), v, 0});
        }
        std::sort(order.begin(), order.end());
        if (order.size() > size_t(LIMITS)) order.resize(LIMITS);

        std::string written;
        for (auto &item : order) {
            int v = item[1];
            Limit l = here[v];
            int face_count = base.GetVertexFaces(v).size();
            bool rim = base.GetVertexEdges(v).size() != face_count;
            auto &last = r->GetLevel(levels);
            int at = became[v], spokes = last.GetVertexEdges(at).size(), sectors = last.GetVertexFaces(at).size();
            Ring whole_ring = ring(last, at, 0, spokes, sectors, c.corners_kept);
            Row powers = expand(whole_ring, whole_ring.position, rows);
            bool agree = apart(l.position, powers) <= 1e-13 && apart(l.position, deeper[v].position) <= 1e-13;
            std::string tangents_by = "masks";
            const char *rule = l.rule == Sdc::Crease::RULE_SMOOTH  ? "smooth"
                               : l.rule == Sdc::Crease::RULE_DART  ? "dart"
                               : l.rule == Sdc::Crease::RULE_CREASE ? "crease"
                                                                    : "corner";
            std::string kind = std::string(rule) + (rim ? ", boundary, " : ", inner, ") + whole(face_count) + " faces";
            bool two_faces = !rim && face_count == 2 && (l.rule == Sdc::Crease::RULE_SMOOTH || l.rule == Sdc::Crease::RULE_DART);
            if (agree) {
                worst_powers = std::max({worst_powers, apart(l.position, powers), apart(l.position, deeper[v].position)});
            } else {
                if (l.rule != Sdc::Crease::RULE_DART && !two_faces) stop(c.name + ": masks and powers disagree: " + kind);
                ++count["position by powers: " + kind];
                worst_masks = std::max(worst_masks, apart(l.position, powers));
                l.position = powers;
            }
            std::vector<int> sharp;
            for (int i = 0; i < spokes; ++i)
                if (last.GetEdgeSharpness(last.GetVertexEdges(at)[i]) > 0) sharp.push_back(i);
            if (two_faces) {
                tangents_by = "";
            } else if (l.rule == Sdc::Crease::RULE_DART) {
                // Away from the crease, and a quarter of a turn on.
                Weights along(whole_ring.global.size()), across(along.size());
                for (int i = 0; i < spokes; ++i) {
                    double angle = 2 * M_PI * (i - sharp.at(0)) / spokes, half = angle + M_PI / spokes;
                    int e = whole_ring.local[far_end(last, at, i)], f = whole_ring.local[opposite(last, at, i)];
                    along[e] = -4 * std::cos(angle), across[e] = -4 * std::sin(angle);
                    along[f] = -std::cos(half), across[f] = -std::sin(half);
                }
                along = tangent(whole_ring, along), across = tangent(whole_ring, across);
                tangents_by = along.empty() || across.empty() ? "" : "powers";
                if (!tangents_by.empty()) l.first = expand(whole_ring, along, rows), l.second = expand(whole_ring, across, rows);
            } else if (l.rule == Sdc::Crease::RULE_SMOOTH) {
                if (!parallel(l.first, deeper[v].first) || !parallel(l.second, deeper[v].second)) stop(c.name + ": tangents " + kind);
            } else if (l.rule == Sdc::Crease::RULE_CREASE) {
                if (!parallel(l.first, deeper[v].first)) stop(c.name + ": tangents along " + kind);
                int from = sharp.at(0), to = sharp.at(1), faces = to - from;
                if (faces > 1) {
                    Ring part = ring(last, at, from, faces + 1, faces, false);
                    Weights inward(part.global.size());
                    for (int i = 0; i <= faces; ++i) inward[part.local[far_end(last, at, from + i)]] = std::sin(M_PI * i / faces);
                    inward = tangent(part, inward);
                    Row found = inward.empty() ? l.second : expand(part, inward, rows);
                    bool same = parallel(l.second, found);
                    if (same != parallel(l.second, deeper[v].second)) stop(c.name + ": tangents across " + kind);
                    if (inward.empty()) tangents_by = "";
                    else if (!same) tangents_by = "powers", l.second = found;
                }
            }
            ++count["tangents by " + (tangents_by.empty() ? "none" : tangents_by) + ": " + kind];
            bool tangents = !tangents_by.empty();
            worst_sum = std::max(worst_sum, std::abs(sum(l.position) - 1));
            if (tangents) worst_slope = std::max({worst_slope, std::abs(sum(l.first)), std::abs(sum(l.second))});
            written += std::string(written.empty() ? "" : ",") + "{\"vertex\":" + whole(v) + ",\"rule\":\"" + rule + "\",\"by\":\"" +
                       (agree ? "masks" : "powers") + "\",\"position\":" + stencil(l.position) + ",\"tangents_by\":\"" +
                       (tangents ? tangents_by : "none") +
                       "\",\"tangents\":[" + (tangents ? stencil(l.first) + "," + stencil(l.second) : "") + "]}";
        }

        std::string refined;
        if (n % 5 == (n / 20) % 5) {
            auto again = refiner(c.faces, int(c.points.size()), c.corners_kept, c.creases, c.corners);
            refine(*again, 2);
            Far::PrimvarRefinerReal<double> primvar(*again);
            std::vector<Position> at(c.points.size());
            for (size_t v = 0; v < at.size(); ++v) at[v].p = c.points[v];
            for (int level = 1; level <= 2; ++level) {
                auto &topology = again->GetLevel(level);
                std::vector<Position> next(topology.GetNumVertices());
                primvar.Interpolate(level, at, next);
                at.swap(next);
                Faces faces(topology.GetNumFaces());
                for (int f = 0; f < topology.GetNumFaces(); ++f)
                    for (int v : topology.GetFaceVertices(f)) faces[f].push_back(v);
                refined += std::string(level == 1 ? ",\"refined\":[" : ",") + "{\"points\":" +
                           list(at, [](auto &p) { return point(p.p); }) + ",\"faces\":" + list(faces, face) + "}";
            }
            refined += "]";
            ++count["cages refined"];
        }
        for (auto &f : c.faces) ++count["faces of " + whole(int(f.size()))];
        ++count["levels " + whole(levels)];
        bool open = false;
        auto side = sides(c.faces);
        for (auto &s : side) open = open || !side.count({s.first.second, s.first.first});
        ++count[std::string(open ? "open" : "closed") + (c.corners_kept ? ", edge and corner" : ", edge only")];
        auto crease = [](auto &e) { return "[" + whole(e.first.first) + "," + whole(e.first.second) + "," + number(e.second) + "]"; };
        auto corner = [](auto &e) { return "[" + whole(e.first) + "," + number(e.second) + "]"; };
        std::string text = "{\"name\":\"" + c.name + "\",\"boundary\":\"" + (c.corners_kept ? "edge-and-corner" : "edge-only");
        text += "\",\"points\":" + list(c.points, point) + ",\"faces\":" + list(c.faces, face);
        text += ",\"creases\":" + list(c.creases, crease) + ",\"corners\":" + list(c.corners, corner);
        text += ",\"levels\":" + whole(levels) + ",\"limits\":[" + written + "]" + refined + "}";
        std::printf("%s\n%s", n ? "," : "", text.c_str());
    }
    std::printf("\n]}\n");
    for (auto &line : count) std::fprintf(stderr, "%5d  %s\n", line.second, line.first.c_str());
    std::fprintf(stderr, "weights of positions sum to 1 within %.1e, of tangents to 0 within %.1e; masks differ from powers by at most %.1e"
                 " where they should agree, and by up to %.1e at the others\n", worst_sum, worst_slope, worst_powers, worst_masks);
    if (worst_sum > 1e-13 || worst_slope > 1e-13) stop("weights do not sum to what they should");
}
