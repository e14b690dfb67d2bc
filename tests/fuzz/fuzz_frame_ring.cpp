// The frame ring: two good frames are written, then the input patches the shared memory as a mad child would,
// eight bytes at a time (offset as 16 bit, value as 64 bit), and the station's end reads on.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "appliance/sensors/frame_ring.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

constexpr deixis::RingGeometry geometry{8, 4, 3, false};

/// The ring's memory as the child sees it.
class Mapping {
  public:
    explicit Mapping(const std::string& name) : size_(deixis::ring_total_bytes(3, 8, 4)) {
        const int file = shm_open(("/" + name).c_str(), O_RDWR, 0);
        if (file < 0) std::abort();
        bytes_ = static_cast<uint8_t*>(mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
        close(file);
        if (bytes_ == MAP_FAILED) std::abort();
    }
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;
    ~Mapping() { munmap(bytes_, size_); }

    void patch(uint16_t offset, uint64_t value) {
        const size_t at = offset % (size_ / sizeof value) * sizeof value;
        std::memcpy(bytes_ + at, &value, sizeof value);
    }

  private:
    size_t size_;
    uint8_t* bytes_ = nullptr;
};

void write_two_frames(const std::string& name) {
    auto writer = deixis::FrameRingWriter::attach(name);
    if (!writer) std::abort();
    const std::array<uint16_t, 32> pixels = {1000, 1001};
    writer->say(deixis::RingState::running, "frames come");
    writer->publish({100, 5000, 1}, pixels);
    writer->publish({200, 6000, 2}, pixels);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    auto reader = deixis::FrameRingReader::create(deixis::unique_ring_name(), geometry);
    if (!reader) std::abort();
    write_two_frames(reader->name());
    Mapping memory(reader->name());
    deixis::DepthFrame frame;
    constexpr size_t patch_bytes = sizeof(uint16_t) + sizeof(uint64_t);
    for (size_t at = 0; at + patch_bytes <= size && at < 40 * patch_bytes; at += patch_bytes) {
        uint16_t offset = 0;
        uint64_t value = 0;
        std::memcpy(&offset, data + at, sizeof offset);
        std::memcpy(&value, data + at + sizeof offset, sizeof value);
        memory.patch(offset, value);
        const auto take = reader->take(frame, 2);
        using Take = deixis::FrameRingReader::Take;
        if (take == Take::frame && frame.depth.millimetres.size() != 32) std::abort();
        if (take == Take::refused_frame || take == Take::refused_ring)
            deixis::expect_one_sentence(reader->refusal());
        deixis::expect_value_or_sentence(reader->status());
        deixis::expect_value_or_sentence(deixis::FrameRingWriter::attach(reader->name()));
    }
    return 0;
}
