// The triangle tests on blocks of four, in terms of the vectors of core/simd.

/// Which triangles of a block a ray hits: one bit each, and where the sure ones are hit. `inexact` ones have an edge
/// function of 0, so that the test of a single triangle has to decide.
template <typename Floats4>
struct BlockHits {
    std::uint32_t sure = 0, inexact = 0;
    Floats4 t, u, v;
};

/// WatertightTest on four triangles.
template <typename Floats4>
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

    /// All sure ones are between the ray's beginning and t_max.
    BlockHits<Floats4> hits(const TriangleBlock& block, float t_max) const noexcept {
        const Sheared a = sheared(block, 0);
        const Sheared b = sheared(block, 1);
        const Sheared c = sheared(block, 2);
        const Floats4 u = c.x * b.y - c.y * b.x;
        const Floats4 v = a.x * c.y - a.y * c.x;
        const Floats4 w = b.x * a.y - b.y * a.x;
        const Floats4 zero = Floats4::filled(0.0f);
        // A NaN among them makes the determinant, and so t, NaN too.
        const std::uint32_t outside = less(min(min(u, v), w), zero).bits() & less(zero, max(max(u, v), w)).bits();
        const std::uint32_t inside = ~outside & 15U;
        if (inside == 0) return {0, 0, zero, zero, zero};
        const std::uint32_t inexact = inside & (equal(u, zero) | equal(v, zero) | equal(w, zero)).bits();
        const Floats4 determinant = (u + v) + w;
        const Floats4 scaled_t = ((u * a.z) + (v * b.z)) + (w * c.z);
        const Floats4 quotient = scaled_t / determinant;
        const std::uint32_t in_range =
            less_equal(t_min_, quotient).bits() & less_equal(quotient, Floats4::filled(t_max)).bits();
        return {inside & ~inexact & in_range & ~equal(determinant, zero).bits(), inexact, quotient, v / determinant,
                w / determinant};
    }

private:
    struct Sheared {
        Floats4 x, y, z;
    };

    [[nodiscard]] Sheared sheared(const TriangleBlock& block, std::size_t vertex) const noexcept {
        const auto& p = block.vertices[vertex];
        const Floats4 z = Floats4::load_aligned(p[z_].data()) - origin_[2];
        return {(Floats4::load_aligned(p[x_].data()) - origin_[0]) - factors_[0] * z,
                (Floats4::load_aligned(p[y_].data()) - origin_[1]) - factors_[1] * z, factors_[2] * z};
    }

    std::size_t x_, y_, z_;
    std::array<Floats4, 3> origin_, factors_;
    Floats4 t_min_;
};

/// MollerTrumboreTest on four triangles.
template <typename Floats4>
class MollerTrumboreLanes {
public:
    MollerTrumboreLanes(const MollerTrumboreTest&, const Ray& ray, float t_min) noexcept
        : origin_(filled(ray.origin)), direction_(filled(ray.direction)), t_min_(Floats4::filled(t_min)) {}

    /// All sure ones are between the ray's beginning and t_max.
    BlockHits<Floats4> hits(const TriangleBlock& block, float t_max) const noexcept {
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
        const std::uint32_t inside = less_equal(zero, u).bits() & less_equal(zero, v).bits() &
                                     less_equal(u + v, Floats4::filled(1.0f)).bits() & ~equal(determinant, zero).bits();
        if (inside == 0) return {0, 0, zero, zero, zero};
        const Floats4 product = dot(edge2, q) * inverse;
        return {inside & less_equal(t_min_, product).bits() & less_equal(product, Floats4::filled(t_max)).bits(), 0,
                product, u, v};
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
        return {Floats4::load_aligned(p[0].data()), Floats4::load_aligned(p[1].data()),
                Floats4::load_aligned(p[2].data())};
    }
    static Vector difference(const Vector& a, const Vector& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    static Vector cross(const Vector& a, const Vector& b) noexcept {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    static Floats4 dot(const Vector& a, const Vector& b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

    Vector origin_, direction_;
    Floats4 t_min_;
};

template <typename Test, typename Floats4>
using LanesOf =
    std::conditional_t<std::is_same_v<Test, WatertightTest>, WatertightLanes<Floats4>, MollerTrumboreLanes<Floats4>>;
