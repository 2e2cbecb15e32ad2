// Tracing through a wide tree, in terms of the vectors of wide_lanes.ipp.

/// The ray's side of the eight box tests of a node; the arithmetic is that of RaySlabs.
class WideBoxTest {
public:
    explicit WideBoxTest(const RaySlabs& slabs) noexcept : t_min_(Floats8::filled(slabs.t_min())) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            near_side_[axis] = slabs.enters_high(axis) ? 1 : 0;
            origin_[axis] = Floats8::filled(slabs.origin(axis));
            inverse_[axis] = Floats8::filled(slabs.inverse(axis));
        }
    }

    /// One bit for each child whose box the ray up to t_max meets, and where it enters each of them.
    std::uint32_t enter(const WideNode& node, float t_max, float* entries) const noexcept {
        Floats8 entry = t_min_;
        Floats8 exit = Floats8::filled(t_max);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t near = near_side_[axis];
            entry = max((Floats8::load(node.bounds[near][axis].data()) - origin_[axis]) * inverse_[axis], entry);
            exit = min((Floats8::load(node.bounds[1 - near][axis].data()) - origin_[axis]) * inverse_[axis], exit);
        }
        entry.store(entries);
        return less_equal(entry, exit * Floats8::filled(kBoxSlack));
    }

private:
    Floats8 t_min_;
    std::array<Floats8, 3> origin_;
    std::array<Floats8, 3> inverse_;
    std::array<std::size_t, 3> near_side_;
};

/// Which triangles of a block a ray hits: one bit each. `inexact` ones have an edge function of 0, so that the test of
/// a single triangle has to decide.
struct BlockHits {
    std::uint32_t sure, inexact;
};

/// WatertightTest on four triangles.
class WatertightLanes {
public:
    WatertightLanes(const WatertightTest& test, const Ray&, float t_min) noexcept
        : x_(test.shear().x),
          y_(test.shear().y),
          z_(test.shear().z),
          origin_{Floats4::filled(test.shear().origin[x_]), Floats4::filled(test.shear().origin[y_]),
                  Floats4::filled(test.shear().origin[z_])},
          factors_{Floats4::filled(test.shear().factor_x), Floats4::filled(test.shear().factor_y),
                   Floats4::filled(test.shear().factor_z)},
          t_min_(Floats4::filled(t_min)) {}

    /// Sets t of the sure ones; all of them are between the ray's beginning and t_max.
    BlockHits hits(const TriangleBlock& block, float t_max, float* t) const noexcept {
        const Sheared a = sheared(block, 0);
        const Sheared b = sheared(block, 1);
        const Sheared c = sheared(block, 2);
        const Floats4 u = c.x * b.y - c.y * b.x;
        const Floats4 v = a.x * c.y - a.y * c.x;
        const Floats4 w = b.x * a.y - b.y * a.x;
        const Floats4 zero = Floats4::filled(0.0f);
        // A NaN among them makes the determinant, and so t, NaN too.
        const std::uint32_t outside = less(min(min(u, v), w), zero) & less(zero, max(max(u, v), w));
        const std::uint32_t inside = ~outside & 15U;
        if (inside == 0) return {0, 0};
        const std::uint32_t inexact = inside & (equal(u, zero) | equal(v, zero) | equal(w, zero));
        const Floats4 determinant = (u + v) + w;
        const Floats4 scaled_t = ((u * a.z) + (v * b.z)) + (w * c.z);
        const Floats4 quotient = scaled_t / determinant;
        quotient.store(t);
        const std::uint32_t in_range = less_equal(t_min_, quotient) & less_equal(quotient, Floats4::filled(t_max));
        return {inside & ~inexact & in_range & ~equal(determinant, zero), inexact};
    }

private:
    struct Sheared {
        Floats4 x, y, z;
    };

    [[nodiscard]] Sheared sheared(const TriangleBlock& block, std::size_t vertex) const noexcept {
        const auto& p = block.vertices[vertex];
        const Floats4 z = Floats4::load(p[z_].data()) - origin_[2];
        return {(Floats4::load(p[x_].data()) - origin_[0]) - factors_[0] * z,
                (Floats4::load(p[y_].data()) - origin_[1]) - factors_[1] * z, factors_[2] * z};
    }

    std::size_t x_, y_, z_;
    std::array<Floats4, 3> origin_, factors_;
    Floats4 t_min_;
};

/// MollerTrumboreTest on four triangles.
class MollerTrumboreLanes {
public:
    MollerTrumboreLanes(const MollerTrumboreTest&, const Ray& ray, float t_min) noexcept
        : origin_(filled(ray.origin)), direction_(filled(ray.direction)), t_min_(Floats4::filled(t_min)) {}

    /// Sets t of the sure ones; all of them are between the ray's beginning and t_max.
    BlockHits hits(const TriangleBlock& block, float t_max, float* t) const noexcept {
        const Vector v0 = vertex(block, 0);
        const Vector edge1 = difference(vertex(block, 1), v0);
        const Vector edge2 = difference(vertex(block, 2), v0);
        const Vector p = cross(direction_, edge2);
        const Floats4 determinant = dot(edge1, p);
        const Floats4 inverse = Floats4::filled(1.0f) / determinant;
        const Vector s = difference(origin_, v0);
        const Vector q = cross(s, edge1);
        const Floats4 u = dot(s, p) * inverse;
        const Floats4 v = dot(direction_, q) * inverse;
        const Floats4 zero = Floats4::filled(0.0f);
        const std::uint32_t inside = less_equal(zero, u) & less_equal(zero, v) &
                                     less_equal(u + v, Floats4::filled(1.0f)) & ~equal(determinant, zero);
        if (inside == 0) return {0, 0};
        const Floats4 product = dot(edge2, q) * inverse;
        product.store(t);
        return {inside & less_equal(t_min_, product) & less_equal(product, Floats4::filled(t_max)), 0};
    }

private:
    struct Vector {
        Floats4 x, y, z;
    };

    static Vector filled(const Vec3& v) noexcept {
        return {Floats4::filled(v.x), Floats4::filled(v.y), Floats4::filled(v.z)};
    }
    static Vector vertex(const TriangleBlock& block, std::size_t i) noexcept {
        const auto& p = block.vertices[i];
        return {Floats4::load(p[0].data()), Floats4::load(p[1].data()), Floats4::load(p[2].data())};
    }
    static Vector difference(const Vector& a, const Vector& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    static Vector cross(const Vector& a, const Vector& b) noexcept {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    static Floats4 dot(const Vector& a, const Vector& b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

    Vector origin_, direction_;
    Floats4 t_min_;
};

template <typename Test>
using LanesOf = std::conditional_t<std::is_same_v<Test, WatertightTest>, WatertightLanes, MollerTrumboreLanes>;

/// Whether one triangle that `hits` names is hit; `t` is what was computed for a sure one. u and v are of no meaning.
template <typename Test>
std::optional<PlaneHit> confirm(const HitRule& rule, const Test& test, const TriangleBlock& block, std::uint32_t lane,
                                const BlockHits& hits, float t) noexcept {
    const TriangleVertices triangle = block.triangle(lane);
    const bool is_sure = (hits.sure >> lane & 1) != 0;
    return rule.accept(triangle, is_sure ? PlaneHit{t, 0.0f, 0.0f} : test.meet(triangle));
}

/// Finds the closest hit in leaves.
template <typename Test>
class ClosestBlock {
public:
    explicit ClosestBlock(const Ray& ray) noexcept
        : rule_(ray), test_(ray), lanes_(test_, ray, rule_.t_min()), t_max_(ray.t_max) {}

    [[nodiscard]] const RaySlabs& slabs() const noexcept { return rule_.slabs(); }

    /// Up to where a box matters.
    [[nodiscard]] float t_max() const noexcept { return t_max_; }

    /// Returns false to end the traversal.
    bool visit(const TriangleBlock& block) noexcept {
        alignas(16) std::array<float, kBlockTriangles> t;
        const BlockHits hits = lanes_.hits(block, t_max_, t.data());
        for (std::uint32_t left = hits.sure | hits.inexact; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            const std::optional<PlaneHit> found = confirm(rule_, test_, block, lane, hits, t[lane]);
            if (found) take(block, lane, found->t);
        }
        return true;
    }

    [[nodiscard]] Hit result() const noexcept {
        if (block_ == nullptr) return {};
        const std::optional<PlaneHit> found = test_.meet(block_->triangle(lane_));
        return found ? Hit{hit_.t, found->u, found->v, hit_.primitive} : Hit{};
    }

private:
    void take(const TriangleBlock& block, std::uint32_t lane, float t) noexcept {
        const std::uint32_t primitive = block.primitive(lane);
        if (!is_closer(t, primitive, hit_)) return;
        hit_.t = t_max_ = t;
        hit_.primitive = primitive;
        block_ = &block;
        lane_ = lane;
    }

    HitRule rule_;
    Test test_;
    LanesOf<Test> lanes_;
    float t_max_;
    Hit hit_;  // without u and v
    const TriangleBlock* block_ = nullptr;
    std::uint32_t lane_ = 0;
};

/// Finds out whether there is a hit.
template <typename Test>
class AnyBlock {
public:
    explicit AnyBlock(const Ray& ray) noexcept : rule_(ray), test_(ray), lanes_(test_, ray, rule_.t_min()) {}

    [[nodiscard]] const RaySlabs& slabs() const noexcept { return rule_.slabs(); }
    [[nodiscard]] float t_max() const noexcept { return rule_.t_max(); }

    bool visit(const TriangleBlock& block) noexcept {
        alignas(16) std::array<float, kBlockTriangles> t;
        const BlockHits hits = lanes_.hits(block, rule_.t_max(), t.data());
        for (std::uint32_t left = hits.sure | hits.inexact; left != 0 && !is_hit_; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            is_hit_ = confirm(rule_, test_, block, lane, hits, t[lane]).has_value();
        }
        return !is_hit_;
    }

    [[nodiscard]] bool result() const noexcept { return is_hit_; }

private:
    HitRule rule_;
    Test test_;
    LanesOf<Test> lanes_;
    bool is_hit_ = false;
};

/// Takes the ray to the blocks of all leaves whose boxes it meets, near ones first.
template <typename Visitor>
void walk(const WideTree& tree, Visitor& visitor, DeferredChild* stack) noexcept {
    const WideBoxTest box_test(visitor.slabs());
    std::size_t size = 0;
    std::uint32_t child = 0;
    for (;;) {
        if ((child & kLeafFlag) != 0) {
            for (const TriangleBlock* block = &tree.blocks[child & ~kLeafFlag];; ++block) {
                if (!visitor.visit(*block)) return;
                if (block->is_last()) break;
            }
        } else {
            const WideNode& node = tree.nodes[child];
            alignas(32) std::array<float, kWideChildren> entries;
            std::uint32_t hits = box_test.enter(node, visitor.t_max(), entries.data());
            const std::size_t bottom = size;
            for (; hits != 0; hits &= hits - 1) {
                const auto slot = static_cast<std::uint32_t>(std::countr_zero(hits));
                std::size_t place = size++;
                for (; place > bottom && stack[place - 1].t < entries[slot]; --place)
                    stack[place] = stack[place - 1];
                stack[place] = {entries[slot], node.children[slot]};
            }
        }
        do {
            if (size == 0) return;
            --size;
        } while (!(stack[size].t <= visitor.t_max() * kBoxSlack));
        child = stack[size].child;
    }
}

template <typename Visitor>
auto trace(const WideTree& tree, const Ray& ray) {
    Visitor visitor(ray);
    if (!tree.nodes.empty() && is_traceable(ray)) {
        WideStack stack(tree.depth);
        walk(tree, visitor, stack.entries());
    }
    return visitor.result();
}

inline WideTracing tracing(TriangleTest test) noexcept {
    if (test == TriangleTest::watertight) return {trace<ClosestBlock<WatertightTest>>, trace<AnyBlock<WatertightTest>>};
    return {trace<ClosestBlock<MollerTrumboreTest>>, trace<AnyBlock<MollerTrumboreTest>>};
}
