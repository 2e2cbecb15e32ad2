// The triangle tests with a ray and a triangle in each lane, in terms of the vectors of core/simd: one ray against the
// four triangles of a block, or eight rays against one triangle.

/// Which lanes are hits: one bit each, and where the sure ones are. `inexact` ones have an edge function of 0, so that
/// the test of a single triangle has to decide.
template <typename Floats>
struct LaneHits {
    std::uint32_t sure = 0, inexact = 0;
    Floats t;
    Floats scaled_u, scaled_v, scale;

    [[nodiscard]] Floats u() const noexcept { return scaled_u / scale; }
    [[nodiscard]] Floats v() const noexcept { return scaled_v / scale; }
};

/// A coordinate of all triangles of a block, a triangle in each lane.
template <typename Floats4>
struct BlockVertices {
    const TriangleBlock& block;

    [[nodiscard]] Floats4 operator()(std::size_t vertex, std::size_t axis) const noexcept {
        return Floats4::load_aligned(block.vertices[vertex][axis].data());
    }
};

/// A coordinate of one triangle of a block, in every lane.
template <typename Floats>
struct TriangleInAllLanes {
    const TriangleBlock& block;
    std::size_t triangle;

    [[nodiscard]] Floats operator()(std::size_t vertex, std::size_t axis) const noexcept {
        return Floats::filled(block.vertices[vertex][axis][triangle]);
    }
};

/// Rays side by side, one in each lane, that have the signs of their directions and their shear axes in common.
template <typename Floats>
struct PacketRays {
    std::array<Floats, 3> origin, direction, inverse;
    Floats t_min, t_max;
    std::array<bool, 3> is_negative;  ///< Of the direction.
    unsigned shear_x, shear_y, shear_z;

    [[nodiscard]] Floats begin() const noexcept { return t_min; }
    [[nodiscard]] Floats end() const noexcept { return t_max; }
    [[nodiscard]] Floats origin_of(unsigned axis) const noexcept { return origin[axis]; }
    [[nodiscard]] Floats inverse_of(unsigned axis) const noexcept { return inverse[axis]; }
};

template <typename Floats>
inline constexpr std::uint32_t kAllLanes = (1U << Floats::kCount) - 1;

/// WatertightTest in each lane.
template <typename Floats>
class WatertightLanes {
public:
    WatertightLanes(const WatertightTest& test, const Ray&, float t_min) noexcept
        : x_(test.shear().x),
          y_(test.shear().y),
          z_(test.shear().z),
          origin_{Floats::filled(test.shear().origin[x_]), Floats::filled(test.shear().origin[y_]),
                  Floats::filled(test.shear().origin[z_])},
          factors_{Floats::filled(test.shear().factor_x), Floats::filled(test.shear().factor_y),
                   Floats::filled(test.shear().factor_z)},
          t_min_(Floats::filled(t_min)) {}

    /// The ray of a shear in every lane.
    WatertightLanes(const std::array<std::uint32_t, 3>& axes, const float* origin, const float* factors,
                    float t_min) noexcept
        : x_(axes[0]),
          y_(axes[1]),
          z_(axes[2]),
          origin_{Floats::filled(origin[x_]), Floats::filled(origin[y_]), Floats::filled(origin[z_])},
          factors_{Floats::filled(factors[0]), Floats::filled(factors[1]), Floats::filled(factors[2])},
          t_min_(Floats::filled(t_min)) {}

    /// Of rays that have the same shear axes.
    explicit WatertightLanes(const PacketRays<Floats>& rays) noexcept
        : x_(rays.shear_x),
          y_(rays.shear_y),
          z_(rays.shear_z),
          origin_{rays.origin[x_], rays.origin[y_], rays.origin[z_]},
          factors_{rays.direction[x_] / rays.direction[z_], rays.direction[y_] / rays.direction[z_], rays.inverse[z_]},
          t_min_(rays.t_min) {}

    /// Of rays that have axes of their own: `vertices` takes 0, 1 and 2 for those that become x, y and z.
    WatertightLanes(const std::array<Floats, 3>& sheared_origin, const std::array<Floats, 3>& factors,
                    Floats t_min) noexcept
        : x_(0), y_(1), z_(2), origin_(sheared_origin), factors_(factors), t_min_(t_min) {}

    /// All sure ones are between the ray's beginning and t_max.
    template <typename Vertices>
    LaneHits<Floats> hits(const Vertices& vertices, Floats t_max) const noexcept {
        const Edges edges = edges_of(vertices);
        if (edges.inside == 0) return {0, 0, edges.u, edges.u, edges.u, edges.u};
        return hits_of(edges, t_max);
    }
    /// The same without a branch.
    template <typename Vertices>
    CLBVH_ALWAYS_INLINE LaneHits<Floats> hits_straight(const Vertices& vertices, Floats t_max) const noexcept {
        return hits_of(edges_of(vertices), t_max);
    }

private:
    struct Sheared {
        Floats x, y, z;
    };
    /// The edge functions, and the vertices' z.
    struct Edges {
        Floats u, v, w, a_z, b_z, c_z;
        std::uint32_t inside;
    };

    template <typename Vertices>
    [[nodiscard]] CLBVH_ALWAYS_INLINE Edges edges_of(const Vertices& vertices) const noexcept {
        const Sheared a = sheared(vertices, 0);
        const Sheared b = sheared(vertices, 1);
        const Sheared c = sheared(vertices, 2);
        const Floats u = c.x * b.y - c.y * b.x;
        const Floats v = a.x * c.y - a.y * c.x;
        const Floats w = b.x * a.y - b.y * a.x;
        const Floats zero = Floats::filled(0.0f);
        // A NaN among them makes the determinant, and so t, NaN too.
        const std::uint32_t outside = less(min(min(u, v), w), zero).bits() & less(zero, max(max(u, v), w)).bits();
        return {u, v, w, a.z, b.z, c.z, ~outside & kAllLanes<Floats>};
    }

    [[nodiscard]] CLBVH_ALWAYS_INLINE LaneHits<Floats> hits_of(const Edges& edges, Floats t_max) const noexcept {
        const Floats u = edges.u, v = edges.v, w = edges.w, zero = Floats::filled(0.0f);
        const std::uint32_t inexact = edges.inside & (equal(u, zero) | equal(v, zero) | equal(w, zero)).bits();
        const Floats determinant = (u + v) + w;
        const Floats scaled_t = ((u * edges.a_z) + (v * edges.b_z)) + (w * edges.c_z);
        const Floats t = scaled_t / determinant;
        const std::uint32_t in_range = less_equal(t_min_, t).bits() & less_equal(t, t_max).bits();
        return {edges.inside & ~inexact & in_range & ~equal(determinant, zero).bits(), inexact, t, v, w, determinant};
    }

    template <typename Vertices>
    [[nodiscard]] CLBVH_ALWAYS_INLINE Sheared sheared(const Vertices& vertices, std::size_t vertex) const noexcept {
        const Floats z = vertices(vertex, z_) - origin_[2];
        return {(vertices(vertex, x_) - origin_[0]) - factors_[0] * z,
                (vertices(vertex, y_) - origin_[1]) - factors_[1] * z, factors_[2] * z};
    }

    std::size_t x_, y_, z_;
    std::array<Floats, 3> origin_, factors_;
    Floats t_min_;
};

/// MollerTrumboreTest in each lane.
template <typename Floats>
class MollerTrumboreLanes {
public:
    MollerTrumboreLanes(const MollerTrumboreTest&, const Ray& ray, float t_min) noexcept
        : origin_(filled(ray.origin)), direction_(filled(ray.direction)), t_min_(Floats::filled(t_min)) {}

    explicit MollerTrumboreLanes(const PacketRays<Floats>& rays) noexcept
        : origin_{rays.origin[0], rays.origin[1], rays.origin[2]},
          direction_{rays.direction[0], rays.direction[1], rays.direction[2]},
          t_min_(rays.t_min) {}

    MollerTrumboreLanes(const std::array<Floats, 3>& origin, const std::array<Floats, 3>& direction,
                        Floats t_min) noexcept
        : origin_{origin[0], origin[1], origin[2]},
          direction_{direction[0], direction[1], direction[2]},
          t_min_(t_min) {}

    /// All sure ones are between the ray's beginning and t_max.
    template <typename Vertices>
    LaneHits<Floats> hits(const Vertices& vertices, Floats t_max) const noexcept {
        return hits_straight(vertices, t_max);
    }
    /// The same without a branch.
    template <typename Vertices>
    CLBVH_ALWAYS_INLINE LaneHits<Floats> hits_straight(const Vertices& vertices, Floats t_max) const noexcept {
        const Vector v0 = vertex(vertices, 0);
        const Vector edge1 = difference(vertex(vertices, 1), v0);
        const Vector edge2 = difference(vertex(vertices, 2), v0);
        const Vector p = cross(direction_, edge2);
        const Floats determinant = dot(edge1, p);
        const Floats zero = Floats::filled(0.0f), one = Floats::filled(1.0f);
        const Floats inverse = one / determinant;
        const Vector s = difference(origin_, v0);
        const Vector q = cross(s, edge1);
        const Floats u = dot(s, p) * inverse;
        const Floats v = dot(direction_, q) * inverse;
        const Floats t = dot(edge2, q) * inverse;
        const std::uint32_t sure = less_equal(zero, u).bits() & less_equal(zero, v).bits() &
                                   less_equal(u + v, one).bits() & ~equal(determinant, zero).bits() &
                                   less_equal(t_min_, t).bits() & less_equal(t, t_max).bits();
        return {sure, 0, t, u, v, one};
    }

private:
    struct Vector {
        Floats x, y, z;
    };

    static Vector filled(const Vec3& v) noexcept {
        return {Floats::filled(v.x), Floats::filled(v.y), Floats::filled(v.z)};
    }
    template <typename Vertices>
    static Vector vertex(const Vertices& vertices, std::size_t i) noexcept {
        return {vertices(i, 0), vertices(i, 1), vertices(i, 2)};
    }
    static Vector difference(const Vector& a, const Vector& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    static Vector cross(const Vector& a, const Vector& b) noexcept {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    static Floats dot(const Vector& a, const Vector& b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

    Vector origin_, direction_;
    Floats t_min_;
};

template <typename Test, typename Floats>
using LanesOf =
    std::conditional_t<std::is_same_v<Test, WatertightTest>, WatertightLanes<Floats>, MollerTrumboreLanes<Floats>>;

/// HitRule in each lane. `Rays` has origin, inverse, t_min and the rays' end as vectors.
template <typename Floats, typename Rays, typename Vertices>
[[nodiscard]] std::uint32_t accepted_hits(const Rays& rays, const Vertices& vertices, std::uint32_t hits, Floats& t) {
    Floats entry = rays.begin();
    Floats exit = rays.end();
    for (unsigned axis = 0; axis < 3; ++axis) {
        const Floats a = vertices(0, axis), b = vertices(1, axis), c = vertices(2, axis);
        const Floats origin = rays.origin_of(axis), inverse = rays.inverse_of(axis);
        const Floats lower = (min(min(a, b), c) - origin) * inverse;
        const Floats upper = (max(max(a, b), c) - origin) * inverse;
        const auto enters_high = less(inverse, Floats::filled(0.0f));
        entry = max(select(enters_high, upper, lower), entry);
        exit = min(select(enters_high, lower, upper), exit);
    }
    const Floats slack = Floats::filled(kBoxSlack);
    const auto is_behind = less(t * slack, entry);
    t = select(is_behind, entry, t);
    return hits & less_equal(entry, exit * slack).bits() & less_equal(t, rays.end()).bits();
}
