#include "clbvh/eval/camera.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/trace/tracer.hpp"

namespace clbvh {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_input, what);
}

bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The tangent of an angle of 0 to pi / 2 by the series of sine and cosine: the C library's differs between platforms.
double tangent(double angle) {
    double sine = 0.0;
    double cosine = 0.0;
    double term = 1.0;
    for (int n = 0; n < 32; ++n) {
        const double signed_term = n % 4 < 2 ? term : -term;
        (n % 2 == 0 ? cosine : sine) += signed_term;
        term *= angle / (n + 1);
    }
    return sine / cosine;
}

/// Half the height of the picture at distance 1.
float half_height(float field_of_view) {
    return static_cast<float>(tangent(static_cast<double>(field_of_view) * std::numbers::pi / 360.0));
}

/// To the right of one who looks along `forward`, with `up` above.
Vec3 right_of(const Vec3& forward, const Vec3& up) {
    for (const Vec3& candidate : {normalized(up), Vec3{0, 0, 1}, Vec3{0, 1, 0}}) {
        const Vec3 right = cross(forward, candidate);
        if (length(right) > 1e-3f) return normalized(right);
    }
    return {1, 0, 0};
}

void check(const Camera& camera, float aspect) {
    if (!is_finite(camera.eye) || !is_finite(camera.target) || !is_finite(camera.up))
        refuse("the camera has a coordinate that is not finite: give it numbers");
    if (camera.eye == camera.target) refuse("the camera's target is at its eye: move one of them");
    if (!(camera.field_of_view >= 1.0f && camera.field_of_view <= 170.0f)) {
        refuse("the camera's field of view is " + std::to_string(camera.field_of_view) +
               " degrees; it has to be 1 to 170");
    }
    if (!(aspect >= 1e-4f && aspect <= 1e4f))
        refuse("the picture's width over its height is " + std::to_string(aspect) + "; it has to be 1e-4 to 1e4");
}

std::vector<float> numbers_in(std::string_view text) {
    std::vector<float> numbers;
    const char* const end = text.data() + text.size();
    for (const char* at = text.data();;) {
        float number = 0.0f;
        const auto [next, error] = std::from_chars(at, end, number);
        if (error != std::errc{} || (next != end && *next != ',')) return {};
        numbers.push_back(number);
        if (next == end) return numbers;
        at = next + 1;
    }
}

std::string shortest(float value) {
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

}  // namespace

ClosestHits closest_hits_of(const Tracer& tracer) {
    return [&tracer](std::span<const Ray> rays, std::span<Hit> hits) { tracer.closest(rays, hits); };
}

CameraRays::CameraRays(const Camera& camera, float aspect) : eye_(camera.eye) {
    check(camera, aspect);
    const float half = half_height(camera.field_of_view);
    forward_ = normalized(camera.target - camera.eye);
    const Vec3 right = right_of(forward_, camera.up);
    right_ = right * (half * aspect);
    down_ = cross(forward_, right) * half;
}

Ray CameraRays::at(float x, float y) const noexcept {
    Ray ray;
    ray.origin = eye_;
    ray.direction = normalized((forward_ + right_ * (2.0f * x - 1.0f)) + down_ * (2.0f * y - 1.0f));
    return ray;
}

Camera parse_camera(std::string_view text, const Vec3& up) {
    const std::vector<float> numbers = numbers_in(text);
    if (numbers.size() != 6 && numbers.size() != 7) {
        refuse("camera \"" + std::string(text) +
               "\": six or seven numbers with commas between them are needed, eye x,y,z, target x,y,z and, where "
               "liked, the field of view in degrees");
    }
    Camera camera;
    camera.eye = {numbers[0], numbers[1], numbers[2]};
    camera.target = {numbers[3], numbers[4], numbers[5]};
    camera.up = up;
    if (numbers.size() == 7) camera.field_of_view = numbers[6];
    static_cast<void>(CameraRays(camera, 1.0f));
    return camera;
}

std::string to_string(const Camera& camera) {
    std::string text;
    for (const float value : {camera.eye.x, camera.eye.y, camera.eye.z, camera.target.x, camera.target.y,
                              camera.target.z, camera.field_of_view}) {
        if (!text.empty()) text += ',';
        text += shortest(value);
    }
    return text;
}

Vec3 parse_axis(std::string_view text) {
    const bool negative = text.starts_with('-');
    const std::string_view name = text.substr(negative ? 1 : 0);
    const float one = negative ? -1.0f : 1.0f;
    if (name == "x") return {one, 0, 0};
    if (name == "y") return {0, one, 0};
    if (name == "z") return {0, 0, one};
    refuse("axis \"" + std::string(text) + "\": it has to be one of x, y, z, -x, -y, -z");
}

}  // namespace clbvh
