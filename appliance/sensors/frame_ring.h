// Depth frames from a sensor child to the station through shared memory: one writer, one reader, no trust.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "appliance/sensors/frame_ring_layout.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

struct RingGeometry {
    int width = 0, height = 0;  ///< pixels, 1 to 8192
    int slots = 8;              ///< 2 to 256
    bool blocking = false;      ///< true: nothing is overwritten, the writer waits for `full` to pass
};

/// One frame as it goes into the ring.
struct RingFrame {
    int64_t timestamp_us = 0;
    int64_t host_us = 0;
    uint64_t frame_id = 0;  ///< from 1, rising
};

/// A name that no other ring of this machine has: "deixis-ring-<pid>-<start of that process>-<number>".
std::string unique_ring_name();

/// Unlinks the rings whose station is no longer alive (killed runs). Returns how many.
int remove_left_over_rings();

/// The child's end.
class FrameRingWriter {
  public:
    /// Opens a ring that a FrameRingReader made and checks every word of its header against the memory's real
    /// size. Refuses, naming the ring and what was expected, anything else.
    static Result<FrameRingWriter> attach(const std::string& name);
    FrameRingWriter(FrameRingWriter&&) noexcept;
    FrameRingWriter& operator=(FrameRingWriter&&) noexcept;
    ~FrameRingWriter();

    RingGeometry geometry() const;
    void beat();
    void say(RingState state, std::string_view sentence = {});  ///< cut to 255 bytes
    bool full() const;                                          ///< blocking rings only
    /// `pixels`: width * height values. On a full ring the oldest frame is overwritten. Counts as a
    /// heartbeat.
    void publish(const RingFrame& frame, std::span<const uint16_t> pixels);
    void count_lost();
    int64_t play_at_us() const;

  private:
    struct Impl;
    explicit FrameRingWriter(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// What the child says of itself, checked.
struct RingStatus {
    RingState state = RingState::created;
    std::string message;
    int process_id = 0;
    int64_t heartbeat_us = 0;
    uint64_t lost_by_child = 0;
};

/// The station's end. Believes nothing: addresses come from its own copy of the geometry, every word that the
/// child can write is checked before use, and a child caught in nonsense is named and not read again.
class FrameRingReader {
  public:
    enum class Take {
        frame,          ///< `out` holds it
        nothing,        ///< none there yet
        refused_frame,  ///< the frame was skipped: `refusal()` says why; the ring goes on
        refused_ring    ///< the ring is not to be trusted any more: `refusal()` says why
    };

    /// Makes the shared memory. Refuses a bad geometry or name, and what the system refuses (name taken, no
    /// space left in shared memory).
    static Result<FrameRingReader> create(const std::string& name, const RingGeometry& geometry);
    FrameRingReader(FrameRingReader&&) noexcept;
    FrameRingReader& operator=(FrameRingReader&&) noexcept;
    ~FrameRingReader();  ///< unlinks the name

    const std::string& name() const;

    /// The next frame in order, pixels copied and verified (checksum, size, order of ids and stamps, 65535).
    /// `out.timestamp_us` is the slot's. In an overwriting ring at most `keep` newest frames stay unread;
    /// older ones are skipped and counted in `dropped`.
    Take take(DepthFrame& out, int keep);

    /// State, message, heartbeat; refuses like `take` with `refused_ring`.
    Result<RingStatus> status();

    /// Frames lie there that `take` has not been asked for, as of the last `take` or `status`.
    bool has_unread() const;

    const std::string& refusal() const;
    uint64_t dropped() const;
    uint64_t frame_id() const;  ///< of the last frame taken
    void play_at(int64_t host_us);
    /// Removes the name; both ends keep their mapping. Done by the destructor at the latest.
    void unlink();

  private:
    struct Impl;
    explicit FrameRingReader(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
