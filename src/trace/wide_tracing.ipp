// Tracing through a wide tree, in terms of the vectors of core/simd and the tests of wide_triangles.ipp. Files that are
// compiled for different instruction sets include both within an anonymous namespace, so that none calls another's
// copy.

inline constexpr std::uint32_t kWidth = 8;

/// Which of the children that a ray meets goes first. Rays that end at any hit are often those which leave a surface
/// and end far away.
enum class ChildOrder { nearest_first, farthest_first, as_stored };

/// A child whose siblings go first, and above it where the ray enters it: no entry is below 0, and so integers order
/// children as entries do.
using DeferredChild = std::uint64_t;

/// Room for all children that one ray can defer: on the stack, or on the heap for trees of an unusual depth.
class WideStack {
public:
    explicit WideStack(std::uint32_t depth) {
        const std::size_t most = std::size_t{depth} * (kWidth - 1) + 1;
        if (most <= few_.size()) return;
        many_ = allocate_stack(most);
        entries_ = many_.get();
    }
    [[nodiscard]] DeferredChild* entries() noexcept { return entries_; }

private:
    std::array<DeferredChild, 512> few_;
    std::unique_ptr<DeferredChild[]> many_;
    DeferredChild* entries_ = few_.data();
};

/// The ray's side of the eight box tests of a node; the arithmetic is that of RaySlabs.
template <typename Floats8>
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
    std::uint32_t enter(const WideNode<8>& node, float t_max, float* entries) const noexcept {
        Floats8 entry = t_min_;
        Floats8 exit = Floats8::filled(t_max);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t near = near_side_[axis];
            entry =
                max((Floats8::load_aligned(node.bounds[near][axis].data()) - origin_[axis]) * inverse_[axis], entry);
            exit =
                min((Floats8::load_aligned(node.bounds[1 - near][axis].data()) - origin_[axis]) * inverse_[axis], exit);
        }
        entry.store_aligned(entries);
        return less_equal(entry, exit * Floats8::filled(kBoxSlack)).bits();
    }

private:
    Floats8 t_min_;
    std::array<Floats8, 3> origin_;
    std::array<Floats8, 3> inverse_;
    std::array<std::size_t, 3> near_side_;
};

[[nodiscard]] inline TriangleVertices triangle_of(const TriangleBlock& block, std::uint32_t lane) noexcept {
    const auto vertex = [&](std::size_t i) {
        return Vec3{block.vertices[i][0][lane], block.vertices[i][1][lane], block.vertices[i][2][lane]};
    };
    return {vertex(0), vertex(1), vertex(2)};
}

/// The ray of a rule in every lane.
template <typename Floats>
class RayInAllLanes {
public:
    explicit RayInAllLanes(const HitRule& rule) noexcept : rule_(rule) {}

    [[nodiscard]] Floats begin() const noexcept { return Floats::filled(rule_.t_min()); }
    [[nodiscard]] Floats end() const noexcept { return Floats::filled(rule_.t_max()); }
    [[nodiscard]] Floats origin_of(unsigned axis) const noexcept { return Floats::filled(rule_.slabs().origin(axis)); }
    [[nodiscard]] Floats inverse_of(unsigned axis) const noexcept {
        return Floats::filled(rule_.slabs().inverse(axis));
    }

private:
    const HitRule& rule_;
};

/// Calls found(hit) with the hits of these triangles of the block up to `t_max`, until it returns false. False where it
/// did.
template <typename Test, typename Found>
bool visit_hits_one_by_one(const TriangleBlock& block, std::uint32_t lanes, const HitRule& rule, const Test& test,
                           float t_max, const Found& found) {
    for (; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        const TriangleVertices triangle = triangle_of(block, lane);
        const std::optional<PlaneHit> hit = rule.accept(triangle, test.meet(triangle));
        if (hit && hit->t <= t_max && !found(Hit{hit->t, hit->u, hit->v, block.primitives[lane]})) return false;
    }
    return true;
}

/// Calls found(hit) with the sure hits of a block's triangles that HitRule lets be hits, until it returns false. False
/// where it did. `rays` has the ray in every lane.
template <typename Floats4, typename Rays, typename Found>
bool visit_accepted(const TriangleBlock& block, const Rays& rays, LaneHits<Floats4>& hits, const Found& found) {
    hits.sure = accepted_hits(rays, BlockVertices<Floats4>{block}, hits.sure, hits.t);
    if (hits.sure == 0) return true;
    alignas(16) std::array<std::array<float, kBlockTriangles>, 3> values;
    hits.t.store_aligned(values[0].data());
    hits.u().store_aligned(values[1].data());
    hits.v().store_aligned(values[2].data());
    for (; hits.sure != 0; hits.sure &= hits.sure - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(hits.sure));
        if (!found(Hit{values[0][lane], values[1][lane], values[2][lane], block.primitives[lane]})) return false;
    }
    return true;
}

/// The same for all triangles of the block at once. `lanes` and `rays` have the ray in every lane;
/// visit_inexact(lanes) does the above for those which have to be looked at one by one.
template <typename Floats4, typename Lanes, typename Rays, typename VisitInexact, typename Found>
bool visit_hits_of(const TriangleBlock& block, const Lanes& lanes, const Rays& rays, float t_max,
                   const VisitInexact& visit_inexact, const Found& found) {
    const BlockVertices<Floats4> vertices{block};
    LaneHits<Floats4> hits = lanes.hits(vertices, Floats4::filled(t_max));
    if ((hits.sure | hits.inexact) == 0) return true;
    if (hits.inexact != 0 && !visit_inexact(hits.inexact)) return false;
    return visit_accepted<Floats4>(block, rays, hits, found);
}

/// What finds hits in leaves has of a ray.
template <typename Set, typename Test>
class BlockVisitor {
public:
    explicit BlockVisitor(const Ray& ray) noexcept : rule_(ray), test_(ray), lanes_(test_, ray, rule_.t_min()) {}

    [[nodiscard]] const RaySlabs& slabs() const noexcept { return rule_.slabs(); }

protected:
    using Floats4 = typename Set::Float4;

    /// Calls found(hit) with each hit of the block's triangles up to `t_max`, until it returns false. False where it
    /// did.
    template <typename Found>
    bool visit_hits(const TriangleBlock& block, float t_max, const Found& found) const {
        const auto visit_inexact = [&](std::uint32_t lanes) {
            return visit_hits_one_by_one(block, lanes, rule_, test_, t_max, found);
        };
        return visit_hits_of<Floats4>(block, lanes_, RayInAllLanes<Floats4>(rule_), t_max, visit_inexact, found);
    }
    [[nodiscard]] float ray_end() const noexcept { return rule_.t_max(); }

private:
    HitRule rule_;
    Test test_;
    LanesOf<Test, Floats4> lanes_;
};

/// Finds the closest hit in leaves.
template <typename Set, typename Test>
class ClosestBlock : public BlockVisitor<Set, Test> {
public:
    static constexpr ChildOrder kOrder = ChildOrder::nearest_first;

    explicit ClosestBlock(const Ray& ray) noexcept : BlockVisitor<Set, Test>(ray), t_max_(ray.t_max) {}

    /// Up to where a box matters.
    [[nodiscard]] float t_max() const noexcept { return t_max_; }

    /// Returns false to end the traversal.
    bool visit(const TriangleBlock& block) noexcept {
        return this->visit_hits(block, t_max_, [&](const Hit& hit) {
            if (is_closer(hit.t, hit.primitive, hit_)) {
                hit_ = hit;
                t_max_ = hit.t;
            }
            return true;
        });
    }

    [[nodiscard]] Hit result() const noexcept { return hit_; }

private:
    float t_max_;
    Hit hit_;
};

/// Finds the closest hit that a filter lets count.
template <typename Set, typename Test>
class FilteredClosestBlock : public BlockVisitor<Set, Test> {
public:
    static constexpr ChildOrder kOrder = ChildOrder::nearest_first;

    FilteredClosestBlock(const Ray& ray, const HitFilter& filter) noexcept
        : BlockVisitor<Set, Test>(ray), ray_(ray), filter_(filter) {}

    [[nodiscard]] float t_max() const noexcept { return hit_ ? hit_.t : this->ray_end(); }

    bool visit(const TriangleBlock& block) {
        return this->visit_hits(block, t_max(), [&](const Hit& hit) {
            if (is_closer(hit.t, hit.primitive, hit_) && filter_(ray_, hit)) hit_ = hit;
            return true;
        });
    }

    [[nodiscard]] Hit result() const noexcept { return hit_; }

private:
    const Ray& ray_;
    const HitFilter& filter_;
    Hit hit_;
};

/// Finds out whether there is a hit.
template <typename Set, typename Test>
class AnyBlock : public BlockVisitor<Set, Test> {
public:
    static constexpr ChildOrder kOrder = ChildOrder::farthest_first;

    using BlockVisitor<Set, Test>::BlockVisitor;

    [[nodiscard]] float t_max() const noexcept { return this->ray_end(); }

    bool visit(const TriangleBlock& block) noexcept {
        is_hit_ = !this->visit_hits(block, t_max(), [](const Hit&) { return false; });
        return !is_hit_;
    }

    [[nodiscard]] bool result() const noexcept { return is_hit_; }

private:
    bool is_hit_ = false;
};

/// Finds out whether there is a hit that a filter lets count.
template <typename Set, typename Test>
class FilteredAnyBlock : public BlockVisitor<Set, Test> {
public:
    static constexpr ChildOrder kOrder = ChildOrder::farthest_first;

    FilteredAnyBlock(const Ray& ray, const HitFilter& filter) noexcept
        : BlockVisitor<Set, Test>(ray), ray_(ray), filter_(filter) {}

    [[nodiscard]] float t_max() const noexcept { return this->ray_end(); }

    bool visit(const TriangleBlock& block) {
        is_hit_ = !this->visit_hits(block, t_max(), [&](const Hit& hit) { return !filter_(ray_, hit); });
        return !is_hit_;
    }

    [[nodiscard]] bool result() const noexcept { return is_hit_; }

private:
    const Ray& ray_;
    const HitFilter& filter_;
    bool is_hit_ = false;
};

/// Collects all hits.
template <typename Set, typename Test>
class AllBlock : public BlockVisitor<Set, Test> {
public:
    static constexpr ChildOrder kOrder = ChildOrder::as_stored;

    AllBlock(const Ray& ray, std::vector<Hit>& hits) noexcept : BlockVisitor<Set, Test>(ray), hits_(hits) {}

    [[nodiscard]] float t_max() const noexcept { return this->ray_end(); }

    bool visit(const TriangleBlock& block) {
        return this->visit_hits(block, t_max(), [&](const Hit& hit) {
            add_hit(hits_, hit);
            return true;
        });
    }

    void result() const noexcept {}

private:
    std::vector<Hit>& hits_;
};

/// Leaves the larger one in `a`, without a branch.
inline void order(DeferredChild& a, DeferredChild& b) noexcept {
    const DeferredChild larger = a > b ? a : b, smaller = a > b ? b : a;
    a = larger;
    b = smaller;
}

/// Puts the children that are hit onto the stack, greater ones first, save the least, which is returned. There are two
/// at least. `deferred(slot)` makes what is put there.
template <typename Deferred>
DeferredChild defer_all_but_least(std::uint32_t hits, const Deferred& deferred, DeferredChild*& top) noexcept {
    const auto take = [&] {
        const auto slot = static_cast<std::uint32_t>(std::countr_zero(hits));
        hits &= hits - 1;
        return deferred(slot);
    };
    DeferredChild a = take(), b = take();
    order(a, b);
    if (hits == 0) {
        *top++ = a;
        return b;
    }
    DeferredChild c = take();
    order(b, c);
    order(a, b);
    if (hits == 0) {
        top[0] = a;
        top[1] = b;
        top += 2;
        return c;
    }
    DeferredChild* const bottom = top;
    top[0] = a;
    top[1] = b;
    top[2] = c;
    top += 3;
    while (hits != 0) {
        const DeferredChild other = take();
        DeferredChild* place = top++;
        for (; place > bottom && place[-1] < other; --place)
            place[0] = place[-1];
        *place = other;
    }
    return *--top;
}

/// Puts the children that are hit onto the stack, last ones first, save the first, which is returned.
inline std::uint32_t defer_all_but_first(const WideNode<8>& node, std::uint32_t hits, DeferredChild*& top) noexcept {
    for (;;) {
        const auto slot = static_cast<std::uint32_t>(31 - std::countl_zero(hits));
        const std::uint32_t other = node.children[slot];
        hits ^= 1U << slot;
        if (hits == 0) return other;
        *top++ = other;
    }
}

/// Takes the ray to the blocks of all leaves whose boxes it meets, in the visitor's order.
template <typename Set, typename Visitor>
void walk(const Wide8& tree, Visitor& visitor, DeferredChild* const stack) {
    const WideBoxTest<typename Set::Float8> box_test(visitor.slabs());
    const WideNode<8>* const nodes = tree.nodes.data();
    const TriangleBlock* const blocks = tree.blocks.data();
    DeferredChild* top = stack;
    std::uint32_t child = 0;
    for (;;) {
        if (!WideChild::is_leaf(child)) {
            const WideNode<8>& node = nodes[child];
            alignas(32) std::array<float, kWidth> entries;
            const std::uint32_t hits = box_test.enter(node, visitor.t_max(), entries.data());
            if (hits != 0) {
                // One child, the most frequent case, goes past the stack.
                if ((hits & (hits - 1)) == 0) {
                    child = node.children[static_cast<std::uint32_t>(std::countr_zero(hits))];
                } else if constexpr (Visitor::kOrder != ChildOrder::as_stored) {
                    std::array<std::uint32_t, kWidth> bits;
                    std::memcpy(bits.data(), entries.data(), sizeof bits);
                    const auto deferred = [&](std::uint32_t slot) {
                        constexpr bool reversed = Visitor::kOrder == ChildOrder::farthest_first;
                        const std::uint32_t key = reversed ? ~bits[slot] : bits[slot];
                        return DeferredChild{key} << 32U | node.children[slot];
                    };
                    child = static_cast<std::uint32_t>(defer_all_but_least(hits, deferred, top));
                } else {
                    child = defer_all_but_first(node, hits, top);
                }
                continue;
            }
        } else {
            const TriangleBlock* block = blocks + WideChild::first_block(child);
            const TriangleBlock* const end = block + WideChild::block_count(child);
            for (; block != end; ++block) {
                if (!visitor.visit(*block)) return;
            }
        }
        const auto reach = std::bit_cast<std::uint32_t>(visitor.t_max() * kBoxSlack);
        do {
            if (top == stack) return;
            --top;
        } while (Visitor::kOrder == ChildOrder::nearest_first && static_cast<std::uint32_t>(*top >> 32U) > reach);
        child = static_cast<std::uint32_t>(*top);
    }
}

template <typename Set, typename Visitor, typename... More>
auto trace(const Wide8& tree, const Ray& ray, More&... more) {
    Visitor visitor(ray, more...);
    if (!tree.nodes.empty() && is_traceable(ray)) {
        WideStack stack(tree.depth);
        walk<Set>(tree, visitor, stack.entries());
    }
    return visitor.result();
}
