// A lock-step replay through real `deixis sensor` processes, kept for a look at it. In: recordings; out: what
// came.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "appliance/sensors/frame_source.h"
#include "tests/appliance/sensors/sensor_stage.h"

namespace deixis::test {

inline FrameSourceParams lock_step() {
    FrameSourceParams params = stage_params();
    params.lock_step = true;
    return params;
}

/// Everything a replay gave: per frameset its stamp and, per sensor, number and stamp of the frame.
struct Replayed {
    struct Line {
        int64_t timestamp_us = 0;
        std::vector<std::optional<std::pair<uint32_t, int64_t>>> frames;
        bool operator==(const Line&) const = default;
    };
    std::vector<Line> lines;
    std::vector<SensorHealth> health;
    bool ended = false;
};

/// Reads to the end, at most a minute; every frame must be the numbered image of its sensor.
inline Replayed replay(FrameSource& source,
                       const std::function<void(size_t line, FrameSource&)>& disturb = {}) {
    Replayed replayed;
    Frameset set;
    within(std::chrono::seconds(60), [&] {
        const auto outcome = source.next(set, std::chrono::milliseconds(100));
        if (outcome == FrameSource::Outcome::end) return replayed.ended = true;
        if (outcome == FrameSource::Outcome::timeout) return false;
        Replayed::Line line{set.timestamp_us, {}};
        for (size_t s = 0; s < set.frames.size(); ++s) {
            const DepthFrame& frame = set.frames[s];
            if (!frame.present) {
                line.frames.emplace_back();
                continue;
            }
            const uint32_t number = frame.depth.millimetres[0];
            const DepthImage expected =
                numbered_image(stage_width, stage_height, number, static_cast<uint32_t>(s));
            EXPECT_EQ(frame.depth.millimetres, expected.millimetres)
                << "sensor " << s << ", frame " << number;
            line.frames.emplace_back(std::pair(number, frame.timestamp_us));
        }
        replayed.lines.push_back(line);
        if (disturb) disturb(replayed.lines.size(), source);
        return false;
    });
    replayed.health = source.health();
    return replayed;
}

inline Replayed replay(const std::vector<SensorSpec>& specs, const FrameSourceParams& params = lock_step(),
                       const std::function<void(size_t, FrameSource&)>& disturb = {}) {
    const auto source = open_stage(specs, params);
    return replay(*source, disturb);
}

inline void expect_finished(const Replayed& replayed) {
    for (const SensorHealth& h : replayed.health)
        EXPECT_EQ(h.state, SensorState::finished) << h.name << " " << name_of(h.state) << ": " << h.reason;
}

}  // namespace deixis::test
