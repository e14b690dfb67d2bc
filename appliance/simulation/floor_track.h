// Who stands where on the floor when: legs of minimum-jerk motion, for the trolley and for the worker's feet.
#pragma once

#include <optional>
#include <vector>

#include "appliance/simulation/scenario.h"
#include "tracking/geometry/rigid_transform.h"

namespace deixis {

/// 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985), clamped to [0, 1] outside.
double minimum_jerk(double share);

/// Angle difference in (-pi, pi].
double wrapped_angle(double angle);

RigidTransform world_from_floor_pose(const FloorPose& pose);

/// `inner` given in the frame of `outer`, as a pose of the world, and back.
FloorPose compose(const FloorPose& outer, const FloorPose& inner);
FloorPose relative_to(const FloorPose& outer, const FloorPose& pose);

struct FloorState {
    FloorPose pose;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< [m/s]
    double distance = 0;                                 ///< walked so far [m]
};

/// A path on the floor in time; before the first leg its start, after the last its end.
class FloorTrack {
  public:
    explicit FloorTrack(const FloorPose& start) : start_(start) {}

    /// Moves to `to` from t0 to t1 (not before the last leg's end).
    void move(double t0, double t1, const FloorPose& to);

    /// Moves together with `carrier` from t0 to t1, keeping the place in its frame.
    void ride(double t0, double t1, const FloorTrack& carrier);

    FloorState at(double t) const;
    const FloorPose& end() const { return legs_.empty() ? start_ : legs_.back().to; }
    bool moving(double t) const;

  private:
    struct Leg {
        double t0, t1;
        FloorPose from, to;
        double distance_before;
        bool rides;
        FloorPose carrier_from, carrier_to;
    };
    FloorPose start_;
    std::vector<Leg> legs_;
};

/// A number in time: holds, and moves between values by minimum jerk.
class ScalarTrack {
  public:
    explicit ScalarTrack(double start = 0) : start_(start) {}
    void move(double t0, double t1, double to);
    double at(double t) const;
    double end() const { return keys_.empty() ? start_ : keys_.back().to; }

  private:
    struct Key {
        double t0, t1, from, to;
    };
    double start_;
    std::vector<Key> keys_;
};

}  // namespace deixis
