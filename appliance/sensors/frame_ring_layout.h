// The bytes of a frame ring in shared memory, as both processes see them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace deixis {

inline constexpr uint64_t ring_magic = 0x31474E4952584544ULL;  ///< "DEXRING1" in file order
inline constexpr uint32_t ring_version = 1;
inline constexpr uint32_t ring_max_side = 8192;  ///< pixels
inline constexpr uint32_t ring_max_slots = 256;
inline constexpr size_t ring_message_bytes = 256;

/// How far the child has come. `ready`: first frame read, waits for `play_at_us`. `finished`: the recording
/// is delivered whole. `refused`: a recording that cannot be played, trying again is useless. `lost`: no
/// device, or it went away.
enum class RingState : uint32_t { created = 1, starting, ready, running, finished, refused, lost };

/// Written once by the station: everything up to `play_at_us`; the rest by the child. Plain atomics without
/// pointers: the station compares every word with what it wrote or last saw before it acts on it.
struct alignas(64) RingHeader {
    std::atomic<uint64_t> magic;
    std::atomic<uint32_t> version;
    std::atomic<uint32_t> header_bytes;
    std::atomic<uint32_t> slots;
    std::atomic<uint32_t> width;
    std::atomic<uint32_t> height;
    std::atomic<uint32_t> blocking;  ///< 1: the child waits for a free slot; 0: it overwrites the oldest
    std::atomic<uint64_t> slot_bytes;
    std::atomic<uint64_t> total_bytes;
    std::atomic<uint64_t> run;        ///< number of this ring, told apart from an older one of the same name
    std::atomic<uint64_t> taken;      ///< frames the station is done with
    std::atomic<int64_t> play_at_us;  ///< host time at which stamp 0 of the recording is played; 0 = not yet

    alignas(64) std::atomic<uint64_t> published;  ///< frames that the child has finished writing
    std::atomic<int64_t> heartbeat_us;            ///< host time of the child's last sign of life
    std::atomic<uint64_t> lost_by_child;  ///< frames that came too late to be played (paced recordings)
    std::atomic<int32_t> process_id;
    std::atomic<uint32_t> state;                    ///< a RingState
    std::atomic<char> message[ring_message_bytes];  ///< one sentence to the state, NUL-terminated
};

/// Followed by the pixels, row-major, padded to `slot_bytes`. `sequence` is 2 n + 1 while frame n (from 0) is
/// being written and 2 n + 2 when it stands.
struct alignas(64) RingSlot {
    std::atomic<uint64_t> sequence;
    std::atomic<int64_t> timestamp_us;  ///< sensor's own clock; of a recording: as in the file
    std::atomic<int64_t> host_us;
    std::atomic<uint64_t> frame_id;  ///< counts the frames of the device or file from 1
    std::atomic<uint64_t> checksum;  ///< XXH3-64 of the pixels
    std::atomic<uint64_t> pixel_bytes;
    std::atomic<uint32_t> width;
    std::atomic<uint32_t> height;
};

static_assert(std::atomic<uint64_t>::is_always_lock_free && std::atomic<uint32_t>::is_always_lock_free);
static_assert(sizeof(RingHeader) % 64 == 0 && sizeof(RingSlot) % 64 == 0);

inline uint64_t ring_slot_bytes(uint32_t width, uint32_t height) {
    const uint64_t pixels = uint64_t{width} * height * sizeof(uint16_t);
    return sizeof(RingSlot) + (pixels + 63) / 64 * 64;
}

inline uint64_t ring_total_bytes(uint32_t slots, uint32_t width, uint32_t height) {
    return sizeof(RingHeader) + slots * ring_slot_bytes(width, height);
}

}  // namespace deixis
