// Encoding and decoding one 640 x 480 depth frame as the recordings do.
#include <benchmark/benchmark.h>

#include "appliance/sessions/depth_codec.h"
#include "tests/appliance/sessions/sample_images.h"

namespace deixis {
namespace {

/// 0: a room with disparity steps, noise and holes; 1: independent values; 2: one value.
DepthImage frame(int64_t kind) {
    if (kind == 0) return testing::room_image(640, 480, 1);
    if (kind == 1) return testing::noise_image(640, 480, 1, 9999);
    return testing::flat_image(640, 480, 1234);
}

void BM_EncodeTable(benchmark::State& state) {
    const DepthImage image = frame(state.range(0));
    DepthEncoder encoder;
    std::vector<uint8_t> coded;
    for (auto _ : state) benchmark::DoNotOptimize(encoder.encode(OniCodec::table, image.millimetres, coded));
    state.counters["bytes"] = static_cast<double>(coded.size());
}
BENCHMARK(BM_EncodeTable)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void BM_DecodeTable(benchmark::State& state) {
    const DepthImage image = frame(state.range(0));
    DepthEncoder encoder;
    std::vector<uint8_t> coded;
    encoder.encode(OniCodec::table, image.millimetres, coded);
    std::vector<uint16_t> pixels(image.millimetres.size());
    for (auto _ : state) benchmark::DoNotOptimize(decode_depth(OniCodec::table, coded, pixels));
}
BENCHMARK(BM_DecodeTable)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deixis

BENCHMARK_MAIN();
