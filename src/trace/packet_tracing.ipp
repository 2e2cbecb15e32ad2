// Tracing eight rays as one, in terms of the vectors of core/simd, of wide_triangles.ipp and of wide_tracing.ipp.

inline constexpr std::size_t kPacketRays = 8;

/// How far the rays of a packet may lie apart: as one they visit whatever any of them has to.
struct PacketLimits {
    float slope;                  ///< Of directions, relative to their largest component.
    std::array<float, 3> origin;  ///< Along each axis.
};

[[nodiscard]] inline PacketLimits packet_limits(const WideNode<8>& root) noexcept {
    constexpr float kSlope = 0.125f, kOrigin = 0.03125f;
    PacketLimits limits{kSlope, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& lower = root.bounds[0][axis];
        const auto& upper = root.bounds[1][axis];
        limits.origin[axis] =
            kOrigin * (*std::max_element(upper.begin(), upper.end()) - *std::min_element(lower.begin(), lower.end()));
    }
    return limits;
}

template <typename Floats8>
[[nodiscard]] float least_lane(const Floats8& values) noexcept {
    return min(values.low_half(), values.high_half()).least();
}

template <typename Floats8>
[[nodiscard]] float greatest_lane(const Floats8& values) noexcept {
    return -least_lane(Floats8::filled(0.0f) - values);
}

template <typename Set>
[[nodiscard]] PacketRays<typename Set::Float8> load_packet(const Ray* rays) noexcept {
    using Float4 = typename Set::Float4;
    using Float8 = typename Set::Float8;
    static_assert(sizeof(Ray) == 8 * sizeof(float));
    std::array<std::array<Float4, 4>, 4> parts;
    for (std::size_t part = 0; part < 4; ++part) {
        const float* const first = reinterpret_cast<const float*>(rays + 4 * (part / 2)) + 4 * (part % 2);
        for (std::size_t i = 0; i < 4; ++i)
            parts[part][i] = Float4::load(first + 8 * i);
        Float4::transpose(parts[part][0], parts[part][1], parts[part][2], parts[part][3]);
    }
    PacketRays<Float8> packet;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        packet.origin[axis] = Float8::of_halves(parts[0][axis], parts[2][axis]);
        packet.direction[axis] = Float8::of_halves(parts[1][axis], parts[3][axis]);
        packet.inverse[axis] = Float8::filled(1.0f) / packet.direction[axis];
    }
    packet.t_min = Float8::of_halves(parts[0][3], parts[2][3]);
    packet.t_max = Float8::of_halves(parts[1][3], parts[3][3]);
    return packet;
}

/// Whether all rays are traceable, with finite inverse directions, in one octant, sheared along the same axis, and
/// close together. It sets what they have in common.
template <typename Floats8>
[[nodiscard]] bool find_common(PacketRays<Floats8>& rays, const PacketLimits& limits) noexcept {
    constexpr std::uint32_t all = kAllLanes<Floats8>;
    const Floats8 zero = Floats8::filled(0.0f);
    Floats8 nothing = zero;  // NaN where anything is infinite or NaN
    std::array<Floats8, 3> sizes;
    for (unsigned axis = 0; axis < 3; ++axis) {
        nothing = nothing + (rays.origin[axis] - rays.origin[axis]) + (rays.direction[axis] - rays.direction[axis]) +
                  (rays.inverse[axis] - rays.inverse[axis]);
        const std::uint32_t negative = less(rays.inverse[axis], zero).bits();
        if (negative != 0 && negative != all) return false;
        rays.is_negative[axis] = negative != 0;
        sizes[axis] = rays.is_negative[axis] ? zero - rays.direction[axis] : rays.direction[axis];
    }
    if ((equal(nothing, zero).bits() & less_equal(rays.t_min, rays.t_max).bits()) != all) return false;
    rays.t_min = max(rays.t_min, zero);
    const std::uint32_t is_y = less(sizes[0], sizes[1]).bits();
    const std::uint32_t is_z = less(max(sizes[0], sizes[1]), sizes[2]).bits();
    if (is_z != all && (is_z != 0 || (is_y != 0 && is_y != all))) return false;
    rays.shear_z = is_z != 0 ? 2 : is_y != 0 ? 1 : 0;
    rays.shear_x = rays.shear_z == 2 ? 0 : rays.shear_z + 1;
    rays.shear_y = rays.shear_x == 2 ? 0 : rays.shear_x + 1;
    std::uint32_t close = all;
    for (const unsigned axis : {rays.shear_x, rays.shear_y}) {
        const Floats8 slope = rays.direction[axis] * rays.inverse[rays.shear_z];
        const Floats8 apart = slope - Floats8::filled(slope.low_half().x());
        close &= less_equal(max(apart, zero - apart), Floats8::filled(limits.slope)).bits();
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        const Floats8 apart = rays.origin[axis] - Floats8::filled(rays.origin[axis].low_half().x());
        close &= less_equal(max(apart, zero - apart), Floats8::filled(limits.origin[axis])).bits();
    }
    if (rays.is_negative[rays.shear_z]) std::swap(rays.shear_x, rays.shear_y);
    return close == all;
}

/// The eight box tests of a node for a packet: the entry is that of the first ray that may enter, the exit that of the
/// last one that may leave. Rounding is monotone: what a ray of the packet meets is met.
template <typename Floats8>
class PacketBoxTest {
public:
    explicit PacketBoxTest(const PacketRays<Floats8>& rays) noexcept : t_min_(Floats8::filled(least_lane(rays.t_min))) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            const Floats8 least = Floats8::filled(least_lane(rays.origin[axis]));
            const Floats8 greatest = Floats8::filled(greatest_lane(rays.origin[axis]));
            near_side_[axis] = rays.is_negative[axis] ? 1 : 0;
            near_origin_[axis] = rays.is_negative[axis] ? least : greatest;
            far_origin_[axis] = rays.is_negative[axis] ? greatest : least;
            least_inverse_[axis] = Floats8::filled(least_lane(rays.inverse[axis]));
            greatest_inverse_[axis] = Floats8::filled(greatest_lane(rays.inverse[axis]));
        }
    }

    std::uint32_t enter(const WideNode<8>& node, float t_max, float* entries) const noexcept {
        Floats8 entry = t_min_;
        Floats8 exit = Floats8::filled(t_max);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t near = near_side_[axis];
            const Floats8 to_near = Floats8::load_aligned(node.bounds[near][axis].data()) - near_origin_[axis];
            const Floats8 to_far = Floats8::load_aligned(node.bounds[1 - near][axis].data()) - far_origin_[axis];
            entry = max(min(to_near * least_inverse_[axis], to_near * greatest_inverse_[axis]), entry);
            exit = min(max(to_far * least_inverse_[axis], to_far * greatest_inverse_[axis]), exit);
        }
        entry.store_aligned(entries);
        return less_equal(entry, exit * Floats8::filled(kBoxSlack)).bits();
    }

private:
    Floats8 t_min_;
    std::array<Floats8, 3> near_origin_, far_origin_, least_inverse_, greatest_inverse_;
    std::array<std::size_t, 3> near_side_;
};

/// What finds hits of eight rays in leaves has of them.
template <typename Set, typename Test>
class Packet {
public:
    using Floats8 = typename Set::Float8;
    using TriangleTestOfRays = Test;

    Packet(const PacketRays<Floats8>& rays, const Ray* first) noexcept : rays_(rays), first_(first), lanes_(rays) {
        rays_.t_max.store_aligned(t_max_.data());
        update_reach();
    }

    [[nodiscard]] const PacketRays<Floats8>& rays() const noexcept { return rays_; }
    /// Up to where a box matters to any of the rays.
    [[nodiscard]] float reach() const noexcept { return reach_; }

    /// Which rays meet a child's box; the arithmetic is that of RaySlabs.
    [[nodiscard]] std::uint32_t meeting(const WideNode<8>& node, std::size_t slot) const noexcept {
        Floats8 entry = rays_.t_min;
        Floats8 exit = Floats8::load_aligned(t_max_.data());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t near = rays_.is_negative[axis] ? 1 : 0;
            entry =
                max((Floats8::filled(node.bounds[near][axis][slot]) - rays_.origin[axis]) * rays_.inverse[axis], entry);
            exit = min((Floats8::filled(node.bounds[1 - near][axis][slot]) - rays_.origin[axis]) * rays_.inverse[axis],
                       exit);
        }
        return less_equal(entry, exit * Floats8::filled(kBoxSlack)).bits();
    }

protected:
    /// Calls found(lane, hit) with each hit of the triangle up to the lane's t_max, which `found` may lower.
    template <typename Found>
    void visit_hits(const TriangleBlock& block, std::size_t triangle, const Found& found) {
        const TriangleInAllLanes<Floats8> vertices{block, triangle};
        LaneHits<Floats8> hits = lanes_.hits(vertices, Floats8::load_aligned(t_max_.data()));
        if ((hits.sure | hits.inexact) == 0) return;
        for (std::uint32_t left = hits.inexact; left != 0; left &= left - 1)
            visit_inexact(block, triangle, static_cast<std::size_t>(std::countr_zero(left)), found);
        hits.sure = accepted_hits(rays_, vertices, hits.sure, hits.t);
        alignas(32) std::array<std::array<float, kPacketRays>, 3> values;
        hits.t.store_aligned(values[0].data());
        hits.u().store_aligned(values[1].data());
        hits.v().store_aligned(values[2].data());
        for (std::uint32_t left = hits.sure; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(left));
            found(lane, Hit{values[0][lane], values[1][lane], values[2][lane], block.primitives[triangle]});
        }
        update_reach();
    }

    alignas(32) std::array<float, kPacketRays> t_max_;

private:
    template <typename Found>
    void visit_inexact(const TriangleBlock& block, std::size_t triangle, std::size_t lane, const Found& found) {
        const HitRule rule(first_[lane]);
        const TriangleVertices vertices = triangle_of(block, static_cast<std::uint32_t>(triangle));
        const std::optional<PlaneHit> hit = rule.accept(vertices, Test(first_[lane]).meet(vertices));
        if (hit && hit->t <= t_max_[lane]) found(lane, Hit{hit->t, hit->u, hit->v, block.primitives[triangle]});
    }
    void update_reach() noexcept { reach_ = greatest_lane(Floats8::load_aligned(t_max_.data())); }

    const PacketRays<Floats8>& rays_;
    const Ray* first_;
    LanesOf<Test, Floats8> lanes_;
    float reach_;
};

/// Finds the closest hits in leaves.
template <typename Set, typename Test>
class ClosestPacket : public Packet<Set, Test> {
public:
    using Result = Hit;
    static constexpr bool kIsAny = false;
    using Packet<Set, Test>::Packet;

    /// Returns false to end the traversal.
    bool visit(const TriangleBlock& block, std::size_t triangle) noexcept {
        this->visit_hits(block, triangle, [&](std::size_t lane, const Hit& hit) {
            if (is_closer(hit.t, hit.primitive, hits_[lane])) {
                hits_[lane] = hit;
                this->t_max_[lane] = hit.t;
            }
        });
        return true;
    }

    void store(Hit* results) const noexcept { std::copy(hits_.begin(), hits_.end(), results); }

private:
    std::array<Hit, kPacketRays> hits_;
};

/// Finds out which rays have a hit.
template <typename Set, typename Test>
class AnyPacket : public Packet<Set, Test> {
public:
    using Result = std::uint8_t;
    static constexpr bool kIsAny = true;
    using Packet<Set, Test>::Packet;

    bool visit(const TriangleBlock& block, std::size_t triangle) noexcept {
        this->visit_hits(block, triangle, [&](std::size_t lane, const Hit&) {
            is_hit_ |= 1U << lane;
            this->t_max_[lane] = -kPositiveInfinity;  // no box matters any more
        });
        return is_hit_ != kAllLanes<typename Set::Float8>;
    }

    void store(std::uint8_t* results) const noexcept {
        for (std::size_t i = 0; i < kPacketRays; ++i)
            results[i] = static_cast<std::uint8_t>(is_hit_ >> i & 1U);
    }

private:
    std::uint32_t is_hit_ = 0;
};

/// Asks for the first lines of a child, which is visited soon.
inline void prefetch_child(const Wide8& tree, std::uint32_t child) noexcept {
    constexpr std::size_t kLines = 3, kLineBytes = 64;
    const void* const node = tree.nodes.data() + child;
    const void* const block = tree.blocks.data() + WideChild::first_block(child);
    const auto* const begin = static_cast<const std::byte*>(WideChild::is_leaf(child) ? block : node);
    for (std::size_t line = 0; line < kLines; ++line)
        prefetch(begin + line * kLineBytes);
}

/// Tests the triangles of a leaf. Returns false to end the traversal.
template <typename Visitor>
bool visit_leaf(const Wide8& tree, std::uint32_t leaf, Visitor& packet) noexcept {
    const TriangleBlock* block = tree.blocks.data() + WideChild::first_block(leaf);
    const TriangleBlock* const end = block + WideChild::block_count(leaf);
    for (; block != end; ++block) {
        for (std::size_t i = 0; i < kBlockTriangles && block->primitives[i] != kNoPrimitive; ++i) {
            if (!packet.visit(*block, i)) return false;
        }
    }
    return true;
}

/// Takes the packet to all leaves whose boxes any of its rays meets, near ones first. False where its rays went so far
/// apart that each had better go alone.
template <typename Set, typename Visitor>
bool walk_packet(const Wide8& tree, Visitor& packet, DeferredChild* const stack) noexcept {
    constexpr int kStartingCredit = 24, kRaysPerVisit = 2;
    const PacketBoxTest<typename Set::Float8> box_test(packet.rays());
    const WideNode<8>* const nodes = tree.nodes.data();
    DeferredChild* top = stack;
    std::uint32_t number = 0;
    int credit = kStartingCredit;
    for (;;) {
        const WideNode<8>& node = nodes[number];
        alignas(32) std::array<float, kWidth> entries;
        const std::uint32_t hits = box_test.enter(node, packet.reach(), entries.data());
        std::array<std::uint32_t, kWidth> bits;
        std::memcpy(bits.data(), entries.data(), sizeof bits);
        // What waits is named by its node and its place there, so that its box is at hand.
        const auto deferred = [&](std::uint32_t slot) {
            prefetch_child(tree, node.children[slot]);
            return DeferredChild{bits[slot]} << 32U | (number * kWidth + slot);
        };
        if (hits != 0) {
            *top = (hits & (hits - 1)) == 0 ? deferred(static_cast<std::uint32_t>(std::countr_zero(hits)))
                                            : defer_all_but_least(hits, deferred, top);
            ++top;
        }
        for (;;) {
            if (top == stack) return true;
            --top;
            if (static_cast<std::uint32_t>(*top >> 32U) > std::bit_cast<std::uint32_t>(packet.reach() * kBoxSlack))
                continue;
            const auto place = static_cast<std::uint32_t>(*top);
            const WideNode<8>& parent = nodes[place / kWidth];
            const std::uint32_t active = packet.meeting(parent, place % kWidth);
            if (active == 0) continue;
            credit += std::popcount(active) - kRaysPerVisit;
            if (credit < 0) return false;
            const std::uint32_t child = parent.children[place % kWidth];
            if (!WideChild::is_leaf(child)) {
                number = child;
                break;
            }
            if (!visit_leaf(tree, child, packet)) return true;
        }
    }
}

/// Traces rays: eight that lie close together as one, others alone.
template <typename Set, typename Visitor, typename SingleVisitor>
class ManyRays {
public:
    using Result = typename Visitor::Result;

    ManyRays(const Wide8& tree, std::span<const Ray> rays, Result* results) noexcept
        : tree_(tree), rays_(rays), results_(results), limits_(packet_limits(tree.nodes[0])), stack_(tree.depth) {}

    void trace_all() {
        std::size_t begin = 0;
        for (; begin + kPacketRays <= rays_.size(); begin += kPacketRays)
            trace_packet(begin);
        for (; begin < rays_.size(); ++begin)
            trace_alone(begin);
    }

private:
    void trace_packet(std::size_t begin) {
        const Ray* const first = rays_.data() + begin;
        PacketRays<typename Set::Float8> loaded = load_packet<Set>(first);
        if (find_common(loaded, limits_)) {
            Visitor packet(loaded, first);
            if (walk_packet<Set>(tree_, packet, stack_.entries())) {
                packet.store(results_ + begin);
                return;
            }
        }
        for (std::size_t i = begin; i < begin + kPacketRays; ++i)
            trace_alone(i);
    }
    void trace_alone(std::size_t i) { results_[i] = trace<Set, SingleVisitor>(tree_, rays_[i]); }

    const Wide8& tree_;
    std::span<const Ray> rays_;
    Result* results_;
    PacketLimits limits_;
    WideStack stack_;
};

/// Traces many rays, with ManyRays or what else has its form.
template <typename Many>
void trace_many(const Wide8& tree, std::span<const Ray> rays, typename Many::Result* results) {
    if (tree.nodes.empty()) {
        std::fill_n(results, rays.size(), typename Many::Result{});
        return;
    }
    Many(tree, rays, results).trace_all();
}

template <typename Set, typename Test, template <typename, typename, typename> class Many>
constexpr WideTracing kTracing{trace<Set, ClosestBlock<Set, Test>>,
                               trace<Set, AnyBlock<Set, Test>>,
                               trace<Set, FilteredClosestBlock<Set, Test>, const HitFilter>,
                               trace<Set, FilteredAnyBlock<Set, Test>, const HitFilter>,
                               trace<Set, AllBlock<Set, Test>, std::vector<Hit>>,
                               trace_many<Many<Set, ClosestPacket<Set, Test>, ClosestBlock<Set, Test>>>,
                               trace_many<Many<Set, AnyPacket<Set, Test>, AnyBlock<Set, Test>>>};

template <typename Set, template <typename, typename, typename> class Many = ManyRays>
WideTracing tracing_of(TriangleTest test) noexcept {
    return test == TriangleTest::watertight ? kTracing<Set, WatertightTest, Many>
                                            : kTracing<Set, MollerTrumboreTest, Many>;
}
