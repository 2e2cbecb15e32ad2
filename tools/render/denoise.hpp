#pragma once

#include <cstdint>
#include <vector>

#include "render/picture.hpp"

namespace clbvh::tool {

/// Light with noise in it, and what is known of each pixel without noise.
struct LitPicture {
    Picture light;
    std::vector<float> variance;  ///< Of each pixel's brightness, the albedo divided out, as a mean of samples.
    Picture albedo;    ///< Factors by which the surface scales colours; ones for the sky and for a ground that is not
                       ///< the mesh's.
    Picture normal;    ///< Of the surface; zero for the sky.
    Picture position;  ///< Of the surface.
    std::vector<std::uint8_t> is_surface;  ///< 1 or 0 each.

    LitPicture(std::uint32_t width, std::uint32_t height);
};

/// Takes noise out of the light of surfaces: each pixel becomes a mean over neighbours that lie in the same plane and
/// are as bright within what the variance explains; the colours of surfaces stay sharp. An edge-avoiding wavelet
/// transform (Dammertz et al. 2010) guided by variance, as in Schied et al. 2017, "Spatiotemporal Variance-Guided
/// Filtering", section 4.3. The more samples, the less it does.
void denoise(LitPicture& picture);

}  // namespace clbvh::tool
