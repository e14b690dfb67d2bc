// Both ends of the frame ring. In: pixels of the child; out: verified frames, or one sentence.
#include "appliance/sensors/frame_ring.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <boost/interprocess/mapped_region.hpp>
#include <boost/interprocess/shared_memory_object.hpp>
#include <cerrno>
#include <cstring>
#include <new>

#include "appliance/sensors/host_clock.h"

namespace deixis {
namespace {

namespace ipc = boost::interprocess;

constexpr int64_t clock_slack_us = 1'000'000;

std::string size_of(uint32_t width, uint32_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

/// Pixels cross the process border as relaxed-free atomic words: acquire and release order them against the
/// slot's sequence without fences, and cost nothing on x86.
void store_pixels(std::byte* target, std::span<const uint16_t> pixels) {
    const size_t bytes = pixels.size_bytes();
    const auto* source = reinterpret_cast<const std::byte*>(pixels.data());
    for (size_t i = 0; i < bytes; i += sizeof(uint64_t)) {
        uint64_t word = 0;
        std::memcpy(&word, source + i, std::min(sizeof word, bytes - i));
        std::atomic_ref(*reinterpret_cast<uint64_t*>(target + i)).store(word, std::memory_order_release);
    }
}

void load_pixels(std::byte* source, std::span<uint16_t> pixels) {
    const size_t bytes = pixels.size_bytes();
    auto* target = reinterpret_cast<std::byte*>(pixels.data());
    for (size_t i = 0; i < bytes; i += sizeof(uint64_t)) {
        const uint64_t word =
            std::atomic_ref(*reinterpret_cast<uint64_t*>(source + i)).load(std::memory_order_acquire);
        std::memcpy(target + i, &word, std::min(sizeof word, bytes - i));
    }
}

bool holds_65535(std::span<const uint16_t> pixels) {
    uint16_t any = 0;
    for (const uint16_t p : pixels) any |= static_cast<uint16_t>(p == 65535);
    return any != 0;
}

/// The mapped memory with the geometry as this process knows it.
struct Mapping {
    ipc::mapped_region region;
    uint32_t slots = 0, width = 0, height = 0;
    bool blocking = false;

    RingHeader& header() const { return *static_cast<RingHeader*>(region.get_address()); }
    std::byte* at(uint64_t frame) const {
        auto* base = static_cast<std::byte*>(region.get_address());
        return base + sizeof(RingHeader) + frame % slots * ring_slot_bytes(width, height);
    }
    RingSlot& slot(uint64_t frame) const { return *reinterpret_cast<RingSlot*>(at(frame)); }
    std::byte* pixels(uint64_t frame) const { return at(frame) + sizeof(RingSlot); }
    size_t pixel_count() const { return size_t{width} * height; }
};

bool usable_name(const std::string& name) {
    return !name.empty() && name.size() <= 200 && name.find('/') == std::string::npos && name.front() != '.';
}

/// The first word of a header that is not what a ring of `size` bytes says; empty when all is well.
std::string fault_of_header(const RingHeader& h, uint64_t size) {
    const uint32_t slots = h.slots, width = h.width, height = h.height;
    if (h.magic != ring_magic) return "does not begin with the ring's mark DEXRING1";
    if (h.version != ring_version)
        return "has version " + std::to_string(h.version) + ", expected " + std::to_string(ring_version);
    if (h.header_bytes != sizeof(RingHeader))
        return "has a header of " + std::to_string(h.header_bytes) + " bytes, expected " +
               std::to_string(sizeof(RingHeader));
    if (slots < 2 || slots > ring_max_slots)
        return "has " + std::to_string(slots) + " slots, expected 2 to " + std::to_string(ring_max_slots);
    if (width < 1 || width > ring_max_side || height < 1 || height > ring_max_side)
        return "has frames of " + size_of(width, height) + ", expected sides of 1 to " +
               std::to_string(ring_max_side);
    if (h.blocking > 1) return "has mode " + std::to_string(h.blocking) + ", expected 0 or 1";
    if (h.slot_bytes != ring_slot_bytes(width, height))
        return "has slots of " + std::to_string(h.slot_bytes) + " bytes, expected " +
               std::to_string(ring_slot_bytes(width, height));
    if (h.total_bytes != ring_total_bytes(slots, width, height))
        return "says it is " + std::to_string(h.total_bytes) + " bytes long, expected " +
               std::to_string(ring_total_bytes(slots, width, height));
    if (h.total_bytes != size)
        return "is " + std::to_string(size) + " bytes long, expected " + std::to_string(h.total_bytes);
    return {};
}

}  // namespace

struct FrameRingWriter::Impl {
    Mapping map;
};

FrameRingWriter::FrameRingWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FrameRingWriter::FrameRingWriter(FrameRingWriter&&) noexcept = default;
FrameRingWriter& FrameRingWriter::operator=(FrameRingWriter&&) noexcept = default;
FrameRingWriter::~FrameRingWriter() = default;

Result<FrameRingWriter> FrameRingWriter::attach(const std::string& name) {
    const std::string who = "frame ring \"" + name + "\" ";
    if (!usable_name(name)) return fail(who + "is not a ring's name");
    auto impl = std::make_unique<Impl>();
    try {
        ipc::shared_memory_object memory(ipc::open_only, name.c_str(), ipc::read_write);
        ipc::offset_t size = 0;
        if (!memory.get_size(size) || size < static_cast<ipc::offset_t>(sizeof(RingHeader)))
            return fail(who + "is " + std::to_string(size) + " bytes long, expected at least " +
                        std::to_string(sizeof(RingHeader)));
        impl->map.region = ipc::mapped_region(memory, ipc::read_write);
    } catch (const ipc::interprocess_exception& e) {
        return fail(who + "cannot be opened: " + e.what());
    }
    Mapping& map = impl->map;
    const std::string fault = fault_of_header(map.header(), map.region.get_size());
    if (!fault.empty()) return fail(who + fault);
    map.slots = map.header().slots;
    map.width = map.header().width;
    map.height = map.header().height;
    map.blocking = map.header().blocking == 1;
    map.header().process_id = getpid();
    FrameRingWriter writer(std::move(impl));
    writer.say(RingState::starting);
    return writer;
}

RingGeometry FrameRingWriter::geometry() const {
    const Mapping& map = impl_->map;
    return {static_cast<int>(map.width), static_cast<int>(map.height), static_cast<int>(map.slots),
            map.blocking};
}

void FrameRingWriter::beat() {
    impl_->map.header().heartbeat_us = host_now_us();
}

void FrameRingWriter::say(RingState state, std::string_view sentence) {
    RingHeader& header = impl_->map.header();
    const size_t length = std::min(sentence.size(), ring_message_bytes - 1);
    for (size_t i = 0; i < length; ++i) header.message[i].store(sentence[i], std::memory_order_relaxed);
    header.message[length].store('\0', std::memory_order_relaxed);
    header.state.store(static_cast<uint32_t>(state), std::memory_order_release);
    beat();
}

bool FrameRingWriter::full() const {
    const RingHeader& header = impl_->map.header();
    return header.published.load(std::memory_order_relaxed) - header.taken.load(std::memory_order_acquire) >=
           impl_->map.slots;
}

void FrameRingWriter::publish(const RingFrame& frame, std::span<const uint16_t> pixels) {
    const Mapping& map = impl_->map;
    const uint64_t n = map.header().published.load(std::memory_order_relaxed);
    RingSlot& slot = map.slot(n);
    const uint64_t checksum = XXH3_64bits(pixels.data(), pixels.size_bytes());
    slot.sequence.store(2 * n + 1, std::memory_order_relaxed);
    // Release on every word after it keeps the odd sequence in front of them.
    slot.timestamp_us.store(frame.timestamp_us, std::memory_order_release);
    slot.host_us.store(frame.host_us, std::memory_order_release);
    slot.frame_id.store(frame.frame_id, std::memory_order_release);
    slot.checksum.store(checksum, std::memory_order_release);
    slot.pixel_bytes.store(pixels.size_bytes(), std::memory_order_release);
    slot.width.store(map.width, std::memory_order_release);
    slot.height.store(map.height, std::memory_order_release);
    store_pixels(map.pixels(n), pixels.first(std::min(pixels.size(), map.pixel_count())));
    slot.sequence.store(2 * n + 2, std::memory_order_release);
    map.header().published.store(n + 1, std::memory_order_release);
    beat();
}

void FrameRingWriter::count_lost() {
    ++impl_->map.header().lost_by_child;
}

int64_t FrameRingWriter::play_at_us() const {
    return impl_->map.header().play_at_us;
}

struct FrameRingReader::Impl {
    std::string name;
    bool linked = false;
    Mapping map;
    uint64_t run = 0;
    uint64_t next = 0;       ///< the frame to be read, counted from 0
    uint64_t published = 0;  ///< as last seen
    uint64_t dropped = 0;
    uint64_t lost = 0;
    uint64_t frame_id = 0;
    int64_t timestamp_us = -1;
    std::string refusal;
    bool distrusted = false;

    Take distrust(std::string sentence) {
        refusal = "frame ring \"" + name + "\" " + std::move(sentence);
        distrusted = true;
        return Take::refused_ring;
    }
    bool header_stands();
    bool follow_published();
    std::string fault_of_slot(const RingSlot& slot, const DepthFrame& frame, uint64_t id) const;
    void done_with(uint64_t frame);

    ~Impl() {
        if (linked) ipc::shared_memory_object::remove(name.c_str());
    }
};

/// The words that only the station writes must still be its own.
bool FrameRingReader::Impl::header_stands() {
    if (distrusted) return false;
    std::string fault = fault_of_header(map.header(), map.region.get_size());
    const RingHeader& h = map.header();
    if (fault.empty() && (h.width != map.width || h.height != map.height || h.slots != map.slots))
        fault = "changed its geometry to " + std::to_string(h.slots) + " slots of " +
                size_of(h.width, h.height) + ", expected " + std::to_string(map.slots) + " of " +
                size_of(map.width, map.height);
    if (fault.empty() && (h.blocking == 1) != map.blocking) fault = "changed its mode while in use";
    if (fault.empty() && h.run != run) fault = "carries the number of another run";
    if (fault.empty() && h.taken != next)
        fault = "changed the count of frames taken, which is not the child's";
    if (!fault.empty()) distrust(fault);
    return fault.empty();
}

bool FrameRingReader::Impl::follow_published() {
    const uint64_t now = map.header().published.load(std::memory_order_acquire);
    if (now < published) {
        distrust("counts backwards: " + std::to_string(now) + " frames after " + std::to_string(published));
        return false;
    }
    if (map.blocking && now - next > map.slots) {
        distrust("holds " + std::to_string(now - next) + " unread frames in " + std::to_string(map.slots) +
                 " slots");
        return false;
    }
    published = now;
    return true;
}

std::string FrameRingReader::Impl::fault_of_slot(const RingSlot& slot, const DepthFrame& frame,
                                                 uint64_t id) const {
    if (slot.width != map.width || slot.height != map.height)
        return "is " + size_of(slot.width, slot.height) + ", expected " + size_of(map.width, map.height);
    if (slot.pixel_bytes != map.pixel_count() * sizeof(uint16_t))
        return "has " + std::to_string(slot.pixel_bytes) + " bytes of pixels, expected " +
               std::to_string(map.pixel_count() * sizeof(uint16_t));
    if (id <= frame_id)
        return "has id " + std::to_string(id) + " after " + std::to_string(frame_id) +
               ", expected ids to rise";
    if (map.blocking && frame_id != 0 && id != frame_id + 1)
        return "has id " + std::to_string(id) + " after " + std::to_string(frame_id) + ": frames are missing";
    if (frame.timestamp_us < 0)
        return "has the stamp " + std::to_string(frame.timestamp_us) + " us, expected none below 0";
    if (frame.timestamp_us < timestamp_us)
        return "has the stamp " + std::to_string(frame.timestamp_us) + " us after " +
               std::to_string(timestamp_us) + " us: time runs backwards";
    if (frame.host_us < 0 || frame.host_us > host_now_us() + clock_slack_us)
        return "arrived at " + std::to_string(frame.host_us) + " us of the host's clock, which is not now";
    if (XXH3_64bits(frame.depth.millimetres.data(), map.pixel_count() * sizeof(uint16_t)) != slot.checksum)
        return "does not match its checksum";
    if (holds_65535(frame.depth.millimetres)) return "holds the value 65535, which is not a depth";
    return {};
}

void FrameRingReader::Impl::done_with(uint64_t frame) {
    next = frame + 1;
    map.header().taken.store(next, std::memory_order_release);
}

FrameRingReader::FrameRingReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FrameRingReader::FrameRingReader(FrameRingReader&&) noexcept = default;
FrameRingReader& FrameRingReader::operator=(FrameRingReader&&) noexcept = default;
FrameRingReader::~FrameRingReader() = default;

Result<FrameRingReader> FrameRingReader::create(const std::string& name, const RingGeometry& geometry) {
    const std::string who = "frame ring \"" + name + "\" ";
    if (!usable_name(name)) return fail(who + "is not a ring's name");
    const int max_side = static_cast<int>(ring_max_side);
    if (geometry.width < 1 || geometry.width > max_side || geometry.height < 1 || geometry.height > max_side)
        return fail(who + "cannot hold frames of " + std::to_string(geometry.width) + "x" +
                    std::to_string(geometry.height) + ", expected sides of 1 to " + std::to_string(max_side));
    if (geometry.slots < 2 || geometry.slots > static_cast<int>(ring_max_slots))
        return fail(who + "cannot have " + std::to_string(geometry.slots) + " slots, expected 2 to " +
                    std::to_string(ring_max_slots));
    auto impl = std::make_unique<Impl>();
    impl->name = name;
    impl->map.slots = static_cast<uint32_t>(geometry.slots);
    impl->map.width = static_cast<uint32_t>(geometry.width);
    impl->map.height = static_cast<uint32_t>(geometry.height);
    impl->map.blocking = geometry.blocking;
    const uint64_t bytes = ring_total_bytes(impl->map.slots, impl->map.width, impl->map.height);
    try {
        const ipc::permissions only_us(0600);
        ipc::shared_memory_object memory(ipc::create_only, name.c_str(), ipc::read_write, only_us);
        impl->linked = true;
        // Reserved now: a full /dev/shm must be a sentence here, not a SIGBUS in the middle of a shift.
        const int error = posix_fallocate(memory.get_mapping_handle().handle, 0, static_cast<off_t>(bytes));
        if (error != 0)
            return fail(who + "needs " + std::to_string(bytes) +
                        " bytes of shared memory: " + std::generic_category().message(error));
        impl->map.region = ipc::mapped_region(memory, ipc::read_write);
    } catch (const ipc::interprocess_exception& e) {
        return fail(who + "cannot be made: " + e.what());
    }
    RingHeader& header = *new (impl->map.region.get_address()) RingHeader{};
    impl->run = static_cast<uint64_t>(host_now_us());
    header.version = ring_version;
    header.header_bytes = sizeof(RingHeader);
    header.slots = impl->map.slots;
    header.width = impl->map.width;
    header.height = impl->map.height;
    header.blocking = geometry.blocking ? 1 : 0;
    header.slot_bytes = ring_slot_bytes(impl->map.width, impl->map.height);
    header.total_bytes = bytes;
    header.run = impl->run;
    header.state = static_cast<uint32_t>(RingState::created);
    header.heartbeat_us = host_now_us();
    for (uint32_t i = 0; i < impl->map.slots; ++i) new (impl->map.at(i)) RingSlot{};
    header.magic = ring_magic;
    return FrameRingReader(std::move(impl));
}

const std::string& FrameRingReader::name() const {
    return impl_->name;
}
const std::string& FrameRingReader::refusal() const {
    return impl_->refusal;
}
bool FrameRingReader::has_unread() const {
    return impl_->published > impl_->next;
}
uint64_t FrameRingReader::dropped() const {
    return impl_->dropped + impl_->lost;
}
uint64_t FrameRingReader::frame_id() const {
    return impl_->frame_id;
}
void FrameRingReader::play_at(int64_t host_us) {
    impl_->map.header().play_at_us = host_us;
}

void FrameRingReader::unlink() {
    if (impl_->linked) ipc::shared_memory_object::remove(impl_->name.c_str());
    impl_->linked = false;
}

FrameRingReader::Take FrameRingReader::take(DepthFrame& out, int keep) {
    Impl& m = *impl_;
    if (!m.header_stands()) return Take::refused_ring;
    for (;;) {
        if (!m.follow_published()) return Take::refused_ring;
        if (m.next == m.published) return Take::nothing;
        if (!m.map.blocking) {
            // The slot after the newest is being written: one less than all can be read in peace.
            const uint64_t most =
                static_cast<uint64_t>(std::clamp(keep, 1, static_cast<int>(m.map.slots) - 1));
            if (m.published - m.next > most) {
                m.dropped += m.published - m.next - most;
                m.done_with(m.published - most - 1);
            }
        }
        const uint64_t n = m.next;
        RingSlot& slot = m.map.slot(n);
        const uint64_t sequence = slot.sequence.load(std::memory_order_acquire);
        if (sequence == 2 * n + 2) {
            out.present = true;
            out.timestamp_us = slot.timestamp_us.load(std::memory_order_acquire);
            out.host_us = slot.host_us.load(std::memory_order_acquire);
            const uint64_t id = slot.frame_id.load(std::memory_order_acquire);
            out.depth.resize(static_cast<int>(m.map.width), static_cast<int>(m.map.height));
            load_pixels(m.map.pixels(n), out.depth.millimetres);
            const std::string fault = m.fault_of_slot(slot, out, id);
            if (slot.sequence.load(std::memory_order_relaxed) == sequence) {
                m.done_with(n);
                if (fault.empty()) {
                    m.frame_id = id;
                    m.timestamp_us = out.timestamp_us;
                    return Take::frame;
                }
                out.present = false;
                m.refusal = "frame " + std::to_string(n + 1) + " of ring \"" + m.name + "\" " + fault;
                return Take::refused_frame;
            }
        }
        // Not frame n, or no longer: an overwriting child may have passed us, anything else is nonsense.
        const uint64_t found = slot.sequence.load(std::memory_order_acquire);
        if (m.map.blocking || found <= 2 * n + 2 || (found - 1) / 2 % m.map.slots != n % m.map.slots ||
            (found - 1) / 2 > m.map.header().published.load(std::memory_order_acquire))
            return m.distrust("has slot " + std::to_string(n % m.map.slots) + " at sequence " +
                              std::to_string(found) + ", expected " + std::to_string(2 * n + 2));
        ++m.dropped;
        m.done_with(n);
    }
}

Result<RingStatus> FrameRingReader::status() {
    Impl& m = *impl_;
    if (!m.header_stands() || !m.follow_published()) return fail(m.refusal);
    const RingHeader& header = m.map.header();
    RingStatus status;
    const uint32_t state = header.state.load(std::memory_order_acquire);
    if (state < static_cast<uint32_t>(RingState::created) || state > static_cast<uint32_t>(RingState::lost)) {
        m.distrust("is in state " + std::to_string(state) + ", which does not exist");
        return fail(m.refusal);
    }
    status.state = static_cast<RingState>(state);
    status.process_id = header.process_id;
    status.heartbeat_us = header.heartbeat_us;
    if (status.heartbeat_us < 0 || status.heartbeat_us > host_now_us() + clock_slack_us) {
        m.distrust("has a heartbeat at " + std::to_string(status.heartbeat_us) +
                   " us of the host's clock, which is still to come");
        return fail(m.refusal);
    }
    status.lost_by_child = header.lost_by_child;
    if (status.lost_by_child < m.lost) {
        m.distrust("counts lost frames backwards: " + std::to_string(status.lost_by_child) + " after " +
                   std::to_string(m.lost));
        return fail(m.refusal);
    }
    m.lost = status.lost_by_child;
    for (const auto& letter : header.message) {
        const char c = letter.load(std::memory_order_relaxed);
        if (c == '\0') return status;
        status.message += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    }
    m.distrust("has a message without an end");
    return fail(m.refusal);
}

}  // namespace deixis
