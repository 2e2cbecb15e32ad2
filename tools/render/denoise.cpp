#include "render/denoise.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <clbvh/core/vector.hpp>
#include <cmath>
#include <cstddef>
#include <utility>

#include "render/colour.hpp"

namespace clbvh::tool {
namespace {

constexpr int kLevels = 5;
constexpr std::array<float, 5> kSpline{1.0f / 16, 1.0f / 4, 3.0f / 8, 1.0f / 4, 1.0f / 16};

/// One picture on its way through the levels.
class Filter {
public:
    explicit Filter(const LitPicture& picture)
        : picture_(picture),
          width_(static_cast<int>(picture.light.width())),
          height_(static_cast<int>(picture.light.height())),
          light_(picture.light.pixels()),
          variance_(picture.variance) {
        for (std::size_t i = 0; i < light_.size(); ++i)
            light_[i] = demodulated(light_[i], picture.albedo.pixels()[i]);
    }

    void run() {
        for (int level = 0; level < kLevels; ++level) {
            smooth_variance();
            std::vector<Vec3> light(light_.size());
            std::vector<float> variance(variance_.size());
            tbb::parallel_for(0, height_, [&](int y) {
                for (int x = 0; x < width_; ++x)
                    gather(x, y, 1 << level, light, variance);
            });
            light_ = std::move(light);
            variance_ = std::move(variance);
        }
    }

    [[nodiscard]] const std::vector<Vec3>& light() const { return light_; }

private:
    [[nodiscard]] std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    [[nodiscard]] bool is_within(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

    /// A pixel's own variance is of few samples, and a poor guide.
    void smooth_variance() {
        smoothed_.resize(variance_.size());
        tbb::parallel_for(0, height_, [&](int y) {
            for (int x = 0; x < width_; ++x) {
                float sum = 0.0f;
                float weights = 0.0f;
                for (int i = 0; i < 9; ++i) {
                    const int dx = i % 3 - 1;
                    const int dy = i / 3 - 1;
                    if (!is_within(x + dx, y + dy)) continue;
                    const float weight = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
                    sum += weight * variance_[index(x + dx, y + dy)];
                    weights += weight;
                }
                smoothed_[index(x, y)] = sum / weights;
            }
        });
    }

    void gather(int x, int y, int step, std::vector<Vec3>& light, std::vector<float>& variance) const {
        const std::size_t here = index(x, y);
        light[here] = light_[here];
        variance[here] = variance_[here];
        if (picture_.is_surface[here] == 0) return;
        Vec3 sum;
        float weights = 0.0f;
        float variances = 0.0f;
        const float spread = 4.0f * std::sqrt(smoothed_[here]) + 1e-6f;
        for (int i = 0; i < 25; ++i) {
            const int column = x + (i % 5 - 2) * step;
            const int line = y + (i / 5 - 2) * step;
            if (!is_within(column, line)) continue;
            const std::size_t there = index(column, line);
            if (picture_.is_surface[there] == 0) continue;
            const float spline = kSpline[static_cast<std::size_t>(i % 5)] * kSpline[static_cast<std::size_t>(i / 5)];
            const float step_in_light = std::abs(brightness(light_[here]) - brightness(light_[there])) / spread;
            const float weight = spline * likeness(here, there) * std::exp(-step_in_light);
            sum = sum + light_[there] * weight;
            variances += weight * weight * variance_[there];
            weights += weight;
        }
        if (weights <= 0.0f) return;
        light[here] = sum * (1.0f / weights);
        variance[here] = variances / (weights * weights);
    }

    /// 1 where two pixels show the same plane, 0 where they have nothing in common.
    [[nodiscard]] float likeness(std::size_t here, std::size_t there) const {
        const Vec3& normal = picture_.normal.pixels()[here];
        float same = std::max(0.0f, dot(normal, picture_.normal.pixels()[there]));
        for (int i = 0; i < 5; ++i)
            same *= same;
        const Vec3 way = picture_.position.pixels()[there] - picture_.position.pixels()[here];
        const float rise = std::abs(dot(normal, way)) / (0.15f * length(way) + 1e-30f);
        return same * std::exp(-rise);
    }

    const LitPicture& picture_;
    int width_;
    int height_;
    std::vector<Vec3> light_;  // the albedo divided out
    std::vector<float> variance_;
    std::vector<float> smoothed_;
};

}  // namespace

LitPicture::LitPicture(std::uint32_t width, std::uint32_t height)
    : light(width, height),
      variance(light.pixels().size()),
      albedo(width, height),
      normal(width, height),
      position(width, height),
      is_surface(light.pixels().size()) {}

void denoise(LitPicture& picture) {
    Filter filter(picture);
    filter.run();
    std::vector<Vec3>& pixels = picture.light.pixels();
    for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = modulated(filter.light()[i], picture.albedo.pixels()[i]);
}

}  // namespace clbvh::tool
