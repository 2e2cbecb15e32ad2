#include "support/device_rays.hpp"

#include <algorithm>

#include "device/opencl/session.hpp"
#include "support/builders.hpp"

namespace clbvh::test {
namespace {

constexpr std::uint64_t kGuard = 256;
constexpr std::uint8_t kGuardByte = 0xa5;

const cl::CommandQueue& queue() {
    return shared_context().session().queue();
}

template <typename T>
std::vector<T> read(const DeviceSpan& span, std::size_t count) {
    std::vector<T> values(count);
    if (count > 0) {
        queue().enqueueReadBuffer(cl::Buffer(span.buffer, true), CL_TRUE, span.offset, count * sizeof(T),
                                  values.data());
    }
    return values;
}

}  // namespace

DeviceRayMemory::Guarded DeviceRayMemory::make_guarded(std::uint64_t bytes) {
    Guarded guarded;
    guarded.bytes = bytes;
    guarded.buffer = cl::Buffer(shared_context().session().context(), CL_MEM_READ_WRITE, bytes + 2 * kGuard);
    guarded.span = {guarded.buffer(), kGuard};
    queue().enqueueFillBuffer(guarded.buffer, kGuardByte, 0, bytes + 2 * kGuard);
    return guarded;
}

DeviceRayMemory::DeviceRayMemory(const DeviceTracer& tracer, const DeviceBvh& bvh, std::span<const Ray> rays,
                                 LayoutKind kind)
    : count_(static_cast<std::uint32_t>(rays.size())) {
    const DeviceTraceSizes sizes = tracer.sizes(bvh, kind);
    rays_ = cl::Buffer(shared_context().session().context(), CL_MEM_READ_ONLY, rays.size_bytes());
    queue().enqueueWriteBuffer(rays_, CL_TRUE, 0, rays.size_bytes(), rays.data());
    results_ = make_guarded(count_ * sizeof(Hit));
    counts_ = make_guarded(count_ * sizeof(RayCounts));
    scratch_ = make_guarded(sizes.scratch);
    layout_ = make_guarded(sizes.layout);
    queue().finish();
}

DeviceRays DeviceRayMemory::rays() const {
    return {count_, {rays_()}, results_.span, counts_.span, scratch_.span};
}

std::vector<Hit> DeviceRayMemory::hits() const {
    return read<Hit>(results_.span, count_);
}

std::vector<std::uint8_t> DeviceRayMemory::bytes() const {
    return read<std::uint8_t>(results_.span, count_);
}

std::vector<RayCounts> DeviceRayMemory::counts() const {
    return read<RayCounts>(counts_.span, count_);
}

bool DeviceRayMemory::guards_are_whole() const {
    return std::ranges::all_of(std::initializer_list<const Guarded*>{&results_, &counts_, &scratch_, &layout_},
                               [](const Guarded* piece) {
                                   const auto is_whole = [&](std::uint64_t begin) {
                                       const auto bytes = read<std::uint8_t>({piece->buffer(), begin}, kGuard);
                                       return std::ranges::count(bytes, kGuardByte) == std::ptrdiff_t{kGuard};
                                   };
                                   return is_whole(0) && is_whole(kGuard + piece->bytes);
                               });
}

}  // namespace clbvh::test
