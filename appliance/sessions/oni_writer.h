// Writes an OpenNI2 recording (.oni) of one 16-bit stream, lossless; ends a torn one. Images in, file out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "appliance/sessions/depth_codec.h"
#include "tracking/geometry/camera_model.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// What a recording says of its stream.
struct OniFormat {
    int width = 0;
    int height = 0;
    double horizontal_fov = 0;  ///< [rad]
    double vertical_fov = 0;    ///< [rad]
    bool infrared = false;      ///< GRAY16 instead of DEPTH_1_MM; 65535 is a value like any other
    int fps = 0;                ///< 0: found from the stamps on `finish`
};

/// Format of a sensor as calibrated; fields of view between the outer edges of the outermost pixels.
OniFormat oni_format_of(const CameraModel& camera, bool infrared);

/// One file, opened by stock OpenNI2 2.2 and read back bit for bit. Pixels are coded as 16zT; from the first
/// frame on that 16zT cannot hold, the whole file is rewritten uncoded, once. Every frame is handed to the
/// kernel when `append` returns, so a killed program loses no frame; until `finish` the heads say "open end",
/// and `mend_recording` closes such a file. Larger than 4 GB is well.
class OniWriter {
  public:
    /// Creates or replaces `path`. Refuses sizes beyond 2,880,000 pixels (OpenNI2's largest frame) and what
    /// the disk refuses.
    static Result<OniWriter> create(const std::filesystem::path& path, const OniFormat& format);
    OniWriter(OniWriter&&) noexcept;
    OniWriter& operator=(OniWriter&&) noexcept;
    ~OniWriter();  ///< without `finish`: leaves a file for `mend_recording`

    /// `timestamp_us` as it shall stand in the file: not negative, not before the frame before. Refuses an
    /// image of another size and, in depth streams, the value 65535. After any refusal, a full disk among
    /// them, the frames before stay good and the writer can go on or finish.
    Result<void> append(int64_t timestamp_us, const DepthImage& image);

    /// Writes seek table and end, patches the heads, waits for the disk. Nothing can be appended after it; a
    /// second call does nothing.
    Result<void> finish();

    int64_t frames() const;
    OniCodec codec() const;

  private:
    struct Impl;
    explicit OniWriter(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

struct MendedRecording {
    int64_t frames = 0;      ///< whole frames that the file now holds
    uint64_t cut_bytes = 0;  ///< torn bytes or zero tail taken off
    bool changed = false;    ///< false: the file was whole
};

/// Makes a recording whole in place: cuts a torn last record or a zero tail (the Recorder leaves one), writes
/// the missing end, patches the heads. Refuses, naming byte and expectation, a file whose head is damaged and
/// one that was closed but has no whole first frame.
Result<MendedRecording> mend_recording(const std::filesystem::path& path);

}  // namespace deixis
