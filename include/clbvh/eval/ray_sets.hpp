#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/eval/camera.hpp"
#include "clbvh/export.h"

// Sets of rays to measure trees with. A set is made once, on any tree over the mesh, and then traced through all trees
// that are compared: closest hits do not depend on the tree, so neither does the set. The same arguments give the same
// rays on every platform and on any number of threads.
namespace clbvh {

/// The kinds of ray sets.
enum class RayKind : std::uint8_t {
    primary,            ///< From the camera through every pixel.
    diffuse,            ///< Two bounces of a diffuse path tracer.
    shadow,             ///< From what the camera sees to point lights.
    ambient_occlusion,  ///< Short rays around what the camera sees.
    random,             ///< Isotropic lines through the whole scene.
};

/// "primary", "diffuse", "shadow", "ao", "random"
[[nodiscard]] CLBVH_EVAL_API std::string_view to_string(RayKind kind) noexcept;
/// The kind of that name, if there is one.
[[nodiscard]] CLBVH_EVAL_API std::optional<RayKind> ray_kind_from(std::string_view name) noexcept;
/// True where rays of this kind are asked only whether they hit anything.
[[nodiscard]] constexpr bool asks_for_any_hit(RayKind kind) noexcept {
    return kind == RayKind::shadow || kind == RayKind::ambient_occlusion;
}

/// One ray through each cell of a grid of `width` x `height` over the picture, line by line from the top, at a random
/// place in its cell. `width` over `height` is the picture's aspect. Throws what CameraRays throws.
[[nodiscard]] CLBVH_EVAL_API std::vector<Ray> primary_rays(const Camera& camera, std::uint32_t width,
                                                           std::uint32_t height, std::uint64_t seed);

/// A "two bounce diffuse path tracer": from the hit of each ray of `primary`, `rays_per_point` rays, distributed as the
/// cosine with the normal (Benthin et al. 2022, "PLOC++", section 5.2, which casts 64); and from the hit of each of
/// those one more of the same kind. First all rays of the first bounce, in the order of `primary`, then those of the
/// second in the order of the first. Rays that hit nothing have no successors.
[[nodiscard]] CLBVH_EVAL_API std::vector<Ray> diffuse_rays(const MeshView& mesh, const ClosestHits& trace,
                                                           std::span<const Ray> primary, std::uint32_t rays_per_point,
                                                           std::uint64_t seed);

/// From the hit of each ray of `primary` one ray to each of `lights`, less those to lights behind the surface. t is 0
/// at the surface and 1 at the light.
[[nodiscard]] CLBVH_EVAL_API std::vector<Ray> shadow_rays(const MeshView& mesh, const ClosestHits& trace,
                                                          std::span<const Ray> primary, std::span<const Vec3> lights);

/// `count` point lights, any number, uniform in the box. Where the camera is outside the box, the box is first made
/// three times as large around its centre. `bounds` must be finite and not empty (lower <= upper). Throws
/// std::bad_alloc.
[[nodiscard]] CLBVH_EVAL_API std::vector<Vec3> random_lights(const Aabb& bounds, const Camera& camera,
                                                             std::uint32_t count, std::uint64_t seed);

/// From the hit of each ray of `primary`, `rays_per_point` rays of the given length, distributed as the cosine with the
/// normal.
[[nodiscard]] CLBVH_EVAL_API std::vector<Ray> ambient_occlusion_rays(const MeshView& mesh, const ClosestHits& trace,
                                                                     std::span<const Ray> primary,
                                                                     std::uint32_t rays_per_point, float length,
                                                                     std::uint64_t seed);

/// `count` lines through the box, isotropic and uniform, which is the distribution that the surface area heuristic
/// assumes: each enters at a uniform place on the box's surface, in a direction distributed as the cosine with the
/// face's normal. They begin outside, a diagonal ahead of that place, and do not end; directions have length 1. Of a
/// box without a surface: none.
[[nodiscard]] CLBVH_EVAL_API std::vector<Ray> random_lines(const Aabb& bounds, std::uint64_t count, std::uint64_t seed);

/// Of make_rays().
struct RaySetOptions {
    std::uint64_t count = 1 << 20;  ///< About how many rays are wanted, 1 to 2^30.
    std::uint64_t seed = 1;         ///< Of the random numbers, any value.
};

/// A set of the kind with about as many rays as wanted: the primary rays of a 4:3 picture of so many pixels, or of as
/// many as need be for so many diffuse rays (64 a point and their successors), shadow rays (4 lights) or ambient
/// occlusion rays (16 a point, a tenth of the diagonal of the mesh's box long). A camera that sees nothing leaves those
/// three empty. Throws Error(invalid_input) for a count of 0 or above 2^30, Error(out_of_memory), and what CameraRays
/// and `trace` throw.
[[nodiscard]] CLBVH_EVAL_API std::vector<Ray> make_rays(RayKind kind, const MeshView& mesh, const ClosestHits& trace,
                                                        const Camera& camera, const RaySetOptions& options);

}  // namespace clbvh
