// Tracing through a wide tree, in terms of the vectors of core/simd and the tests of wide_triangles.ipp. Files that are
// compiled for different instruction sets include both within an anonymous namespace, so that none calls another's
// copy.

/// Room for all children that one ray can defer: on the stack, or on the heap for trees of an unusual depth.
class WideStack {
public:
    explicit WideStack(std::uint32_t depth) {
        const std::size_t most = std::size_t{depth} * (kWideChildren - 1) + 1;
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

/// Asks for all of a node or block that will be visited, unless it gets out of the ray's reach until then.
inline void prefetch([[maybe_unused]] const WideTree& tree, [[maybe_unused]] std::uint32_t child) noexcept {
#if defined(__GNUC__)
    constexpr std::size_t line = 64;
    const bool is_leaf = (child & kLeafFlag) != 0;
    const auto* const begin = is_leaf ? reinterpret_cast<const char*>(&tree.blocks[child & ~kLeafFlag])
                                      : reinterpret_cast<const char*>(&tree.nodes[child]);
    const std::size_t bytes = is_leaf ? sizeof(TriangleBlock) : sizeof(WideNode);
    for (std::size_t offset = 0; offset < bytes; offset += line)
        __builtin_prefetch(begin + offset);
#endif
}

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
    std::uint32_t enter(const WideNode& node, float t_max, float* entries) const noexcept {
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

/// Whether one triangle that `hits` names is hit; `t` is what was computed for a sure one. u and v are of no meaning.
template <typename Test>
std::optional<PlaneHit> confirm(const HitRule& rule, const Test& test, const TriangleBlock& block, std::uint32_t lane,
                                const BlockHits& hits, float t) noexcept {
    const TriangleVertices triangle = block.triangle(lane);
    const bool is_sure = (hits.sure >> lane & 1) != 0;
    return rule.accept(triangle, is_sure ? PlaneHit{t, 0.0f, 0.0f} : test.meet(triangle));
}

/// Finds the closest hit in leaves.
template <typename Set, typename Test>
class ClosestBlock {
public:
    static constexpr bool kNearFirst = true;

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
    LanesOf<Test, typename Set::Float4> lanes_;
    float t_max_;
    Hit hit_;  // without u and v
    const TriangleBlock* block_ = nullptr;
    std::uint32_t lane_ = 0;
};

/// Finds out whether there is a hit.
template <typename Set, typename Test>
class AnyBlock {
public:
    static constexpr bool kNearFirst = false;

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
    LanesOf<Test, typename Set::Float4> lanes_;
    bool is_hit_ = false;
};

/// Puts the children that are hit onto the stack, far ones first, save the nearest, which is returned.
inline std::uint32_t defer_all_but_nearest(const WideTree& tree, const WideNode& node, const float* entries,
                                           std::uint32_t hits, DeferredChild* stack, std::size_t& size) noexcept {
    auto slot = static_cast<std::uint32_t>(std::countr_zero(hits));
    DeferredChild nearest{entries[slot], node.children[slot]};
    const std::size_t bottom = size;
    for (hits &= hits - 1; hits != 0; hits &= hits - 1) {
        slot = static_cast<std::uint32_t>(std::countr_zero(hits));
        DeferredChild other{entries[slot], node.children[slot]};
        if (other.t < nearest.t) std::swap(nearest, other);
        std::size_t place = size++;
        for (; place > bottom && stack[place - 1].t < other.t; --place)
            stack[place] = stack[place - 1];
        stack[place] = other;
        prefetch(tree, other.child);
    }
    return nearest.child;
}

/// Puts the children that are hit onto the stack, last ones first, save the first, which is returned.
inline std::uint32_t defer_all_but_first(const WideTree& tree, const WideNode& node, std::uint32_t hits,
                                         DeferredChild* stack, std::size_t& size) noexcept {
    for (;;) {
        const auto slot = static_cast<std::uint32_t>(31 - std::countl_zero(hits));
        const std::uint32_t other = node.children[slot];
        hits ^= 1U << slot;
        if (hits == 0) return other;
        stack[size++] = {0.0f, other};
        prefetch(tree, other);
    }
}

/// Takes the ray to the blocks of all leaves whose boxes it meets, near ones first where the visitor needs them so.
template <typename Set, typename Visitor>
void walk(const WideTree& tree, Visitor& visitor, DeferredChild* stack) noexcept {
    const WideBoxTest<typename Set::Float8> box_test(visitor.slabs());
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
            if (hits != 0) {
                if constexpr (Visitor::kNearFirst) {
                    child = defer_all_but_nearest(tree, node, entries.data(), hits, stack, size);
                } else {
                    child = defer_all_but_first(tree, node, hits, stack, size);
                }
                continue;
            }
        }
        do {
            if (size == 0) return;
            --size;
        } while (!(stack[size].t <= visitor.t_max() * kBoxSlack));
        child = stack[size].child;
    }
}

template <typename Set, template <typename, typename> typename Block, typename Test>
auto trace(const WideTree& tree, const Ray& ray) {
    Block<Set, Test> visitor(ray);
    if (!tree.nodes.empty() && is_traceable(ray)) {
        WideStack stack(tree.depth);
        walk<Set>(tree, visitor, stack.entries());
    }
    return visitor.result();
}

template <typename Set>
WideTracing tracing_of(TriangleTest test) noexcept {
    if (test == TriangleTest::watertight) {
        return {trace<Set, ClosestBlock, WatertightTest>, trace<Set, AnyBlock, WatertightTest>};
    }
    return {trace<Set, ClosestBlock, MollerTrumboreTest>, trace<Set, AnyBlock, MollerTrumboreTest>};
}
