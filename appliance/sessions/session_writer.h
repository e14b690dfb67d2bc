// Writes a session folder: streams, background, part, truth, settings. Images in; a whole session or none
// out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "appliance/sessions/depth_png.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// What session.toml says of its making.
struct SessionOrigin {
    std::string name;
    std::string created;  ///< RFC 3339 UTC, e.g. "2026-11-22T10:00:00Z"; the caller's clock or seed
    std::map<std::string, std::string> tools;  ///< program name to version
};

/// Works in `<folder>.recording` and renames it to `folder` in `finish`: a half-written session is never
/// taken for a whole one. `mend_session` makes a session of a `.recording` folder whose writer died. Not
/// thread-safe.
///
///     auto writer = SessionWriter::create("demo", rig, {"demo", "2026-11-22T10:00:00Z", {{"deixis",
///     "0.1.0"}}}); writer->append(0, 33'333, left_image); writer->append(1, 35'000, right_image);
///     writer->add_truth_line(R"({"timestamp_us": 33333})");
///     auto done = writer->finish();
class SessionWriter {
  public:
    /// Writes calibration.toml. Refuses an existing `folder` or `.recording` folder, an unusable `created`,
    /// sensors larger than a recording holds, and what the disk refuses.
    static Result<SessionWriter> create(const std::filesystem::path& folder, const SensorRig& rig,
                                        const SessionOrigin& origin);
    SessionWriter(SessionWriter&&) noexcept;
    SessionWriter& operator=(SessionWriter&&) noexcept;
    ~SessionWriter();  ///< without `finish`: the `.recording` folder stays for `mend_session`

    /// One frame of sensor `sensor` (index in the rig; depth or infrared), stamps on the session clock,
    /// strictly rising a sensor; `host_us` on every frame of a sensor or on none. Refuses other sizes,
    /// stamps that do not rise, 65535 in depth, a full disk; what was written before stays good.
    Result<void> append(size_t sensor, int64_t timestamp_us, const DepthImage& image,
                        std::optional<int64_t> host_us = std::nullopt);

    /// One frame of a video sensor.
    Result<void> append(size_t sensor, int64_t timestamp_us, const VideoImage& image,
                        std::optional<int64_t> host_us = std::nullopt);

    /// The empty cell as depth sensor `sensor` sees it.
    Result<void> set_background(size_t sensor, const DepthImage& image);

    /// Copies part.toml and, beside it, the model file it names (relative to part.toml), keeping the file's
    /// name.
    Result<void> copy_part(const std::filesystem::path& part_toml);

    /// One JSON object as one line of truth.jsonl.
    Result<void> add_truth_line(std::string_view json_object);

    /// Whole files: truth.jsonl, expected.toml, settings.toml, calibration.toml.
    Result<void> copy_truth(const std::filesystem::path& file);
    Result<void> copy_expected(const std::filesystem::path& file);
    Result<void> copy_settings(const std::filesystem::path& file);
    Result<void> copy_calibration(const std::filesystem::path& file);  ///< the caller has read `rig` from it
    Result<void> set_expected(std::string_view toml);
    Result<void> set_settings(std::string_view toml);

    /// Closes the streams, writes session.toml with the checksums, waits for the disk, renames the folder.
    Result<void> finish();

    /// Where the files lie until `finish`.
    const std::filesystem::path& working_folder() const;

  private:
    struct Impl;
    explicit SessionWriter(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Ends an interrupted recording: `recording_folder` is the `<folder>.recording` left behind. Mends each
/// stream, writes session.toml and renames the folder to `<folder>`, which it returns.
Result<std::filesystem::path> mend_session(const std::filesystem::path& recording_folder);

}  // namespace deixis
