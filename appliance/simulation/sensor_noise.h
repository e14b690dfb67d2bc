// From a perfect depth layer to what a Kinect-class sensor reports: published noise, keyed by frame and
// pixel.
#pragma once

#include <array>
#include <cstdint>

#include "appliance/simulation/depth_view.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

struct SensorNoiseParams {
    double level = 1.0;         ///< factor on all random parts; 0 leaves steps, shadow, slant limit and range
    double step = 2.85e-3;      ///< disparity step in depth over z^2 [1/m] (Khoshelham & Oude Elberink 2012)
    double edge_sigma = 0.5;    ///< jitter of the sampled pixel, each axis (Barron & Malik 2013) [pixel]
    double slant_limit = 80.0;  ///< no return beyond, fading over +-3 (Nguyen et al. 2012) [degree]
    double speckle = 0.002;     ///< share of pixels without return for no reason
    double nearest = 0.5;       ///< range along the axis [m]
    double farthest = 4.5;      ///< [m]
    InvalidSettings validate() const;
};

/// Standard deviation along the axis [m] at depth z [m] and angle of incidence [rad] (Nguyen et al. 2012).
double axial_sigma(double z, double incidence);

/// The noise of one sensor. Depends on (seed, frame, pixel) only.
class SensorNoise {
  public:
    explicit SensorNoise(const SensorNoiseParams& params);

    /// Millimetres of `layer` as seen in frame `frame`: jittered at edges (so that pixels flip between near
    /// and far), axial noise in disparity so that it adds up with the rounding to `axial_sigma`, rounded to
    /// whole disparity steps, without return in shadow, at grazing angles, out of range and at random.
    void apply(uint64_t seed, uint64_t frame, const DepthLayer& layer, int width, int height,
               DepthImage& out) const;

    const SensorNoiseParams& params() const { return params_; }

  private:
    static constexpr int depths = 128, slants = 64;
    double steps_of_noise(float z, float cosine) const;

    SensorNoiseParams params_;
    std::array<std::array<float, slants>, depths> steps_{};  ///< no pixel needs an arc cosine
};

}  // namespace deixis
