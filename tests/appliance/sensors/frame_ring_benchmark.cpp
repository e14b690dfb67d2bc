// What it costs to hand one 640x480 frame from the child to the station: checksum and copy on each side.
#include <benchmark/benchmark.h>

#include "appliance/sensors/frame_ring.h"
#include "appliance/sensors/host_clock.h"
#include "tests/appliance/sensors/ring_images.h"

namespace deixis {
namespace {

struct BenchRing {
    FrameRingReader reader = std::move(*FrameRingReader::create(unique_ring_name(), {640, 480, 8, false}));
    FrameRingWriter writer = std::move(*FrameRingWriter::attach(reader.name()));
    DepthImage image = test::numbered_image(640, 480, 1);
    uint64_t id = 0;
    void publish() {
        ++id;
        writer.publish({static_cast<int64_t>(id), host_now_us(), id}, image.millimetres);
    }
};

void publish(benchmark::State& state) {
    BenchRing ring;
    for (auto _ : state) ring.publish();
}

void publish_and_take(benchmark::State& state) {
    BenchRing ring;
    DepthFrame frame;
    for (auto _ : state) {
        ring.publish();
        if (ring.reader.take(frame, 1) != FrameRingReader::Take::frame) state.SkipWithError("frame refused");
    }
}

BENCHMARK(publish)->Unit(benchmark::kMicrosecond);
BENCHMARK(publish_and_take)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace deixis

BENCHMARK_MAIN();
