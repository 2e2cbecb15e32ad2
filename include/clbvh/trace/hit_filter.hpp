#pragma once

#include <concepts>
#include <type_traits>

#include "clbvh/core/ray.hpp"

namespace clbvh {

/// Asks the caller of each hit whether it counts; where it does not, the ray goes on, as through a hole in a leaf's
/// texture. Borrows the function, as a parameter does: filter and function must not outlive the call.
///
///     tracer.closest(ray, [&](const clbvh::Ray&, const clbvh::Hit& hit) { return alpha(hit) > 0.5f; });
///
/// It is called for hits in no order, not for all of them, and by any(span) and closest(span) from several threads at a
/// time. What it throws leaves the call.
class HitFilter {
public:
    // NOLINTBEGIN(google-explicit-constructor): a filter is what the function is
    template <typename Function>
    requires std::predicate<const Function&, const Ray&, const Hit&> &&
        (!std::same_as<Function, HitFilter>)HitFilter(const Function& function) noexcept {
        if constexpr (std::is_function_v<Function>) {
            function_.plain = reinterpret_cast<void (*)()>(&function);
            call_ = [](const Callee& callee, const Ray& ray, const Hit& hit) -> bool {
                return reinterpret_cast<const Function*>(callee.plain)(ray, hit);
            };
        } else {
            function_.object = &function;
            call_ = [](const Callee& callee, const Ray& ray, const Hit& hit) -> bool {
                return (*static_cast<const Function*>(callee.object))(ray, hit);
            };
        }
    }
    // NOLINTEND(google-explicit-constructor)

    [[nodiscard]] bool operator()(const Ray& ray, const Hit& hit) const { return call_(function_, ray, hit); }

private:
    union Callee {
        const void* object;
        void (*plain)();
    };

    Callee function_;
    bool (*call_)(const Callee& callee, const Ray& ray, const Hit& hit);
};

}  // namespace clbvh
