// Random numbers by counter: a pure function of (seed, stream, counter), so that no order of calls can change
// them.
#pragma once

#include <cmath>
#include <cstdint>

namespace deixis {

/// SplitMix64 finaliser (Steele, Lea, Flood 2014) over a keyed counter.
class CounterRandom {
  public:
    CounterRandom(uint64_t seed, uint64_t stream) : key_(mix(mix(seed + golden) ^ (stream * golden))) {}

    uint64_t bits(uint64_t counter) const { return mix(key_ + counter * golden); }

    /// In [0, 1).
    double uniform(uint64_t counter) const { return static_cast<double>(bits(counter) >> 11) * 0x1p-53; }
    double uniform(uint64_t counter, double low, double high) const {
        return low + (high - low) * uniform(counter);
    }

    /// Standard normal as the sum of four 16 bit uniforms (Irwin-Hall): cheap enough for every pixel, the
    /// same on every machine, tails end at 3.46.
    double normal(uint64_t counter) const {
        const uint64_t b = bits(counter);
        const uint64_t sum = (b & 0xFFFF) + (b >> 16 & 0xFFFF) + (b >> 32 & 0xFFFF) + (b >> 48);
        return (static_cast<double>(sum) - 131070.0) * (1.0 / 37837.2);  // 65536 * sqrt(4 / 12)
    }

  private:
    static constexpr uint64_t golden = 0x9E3779B97F4A7C15U;
    static uint64_t mix(uint64_t x) {
        x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
        x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
        return x ^ (x >> 31);
    }
    uint64_t key_;
};

/// The same as a running sequence, for drawing a scenario.
class DrawSequence {
  public:
    DrawSequence(uint64_t seed, uint64_t stream) : random_(seed, stream) {}
    double uniform(double low, double high) { return random_.uniform(next_++, low, high); }
    double normal() { return random_.normal(next_++); }
    bool coin() { return uniform(0, 1) < 0.5; }
    /// 0 .. count - 1.
    size_t index(size_t count) { return static_cast<size_t>(random_.bits(next_++) % count); }

  private:
    CounterRandom random_;
    uint64_t next_ = 0;
};

}  // namespace deixis
