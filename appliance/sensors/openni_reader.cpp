// OpenNI2 behind a small door, its known traps walked around. In: a device or file; out: depth frames.
#include "appliance/sensors/openni_reader.h"

#include <OpenNI.h>
#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <optional>
#include <thread>
#include <utility>

namespace deixis {
namespace {

constexpr size_t longest_path = 255;  ///< OpenNI2 refuses longer ones, and dies of bytes that are not ASCII
/// OpenNI2's player walks its stream list without a lock for a moment after `stop`.
constexpr std::chrono::milliseconds after_stop{40};

/// What OpenNI2 says went wrong: it ends its texts with a newline or two.
std::string openni_reason() {
    std::string text = one_line(openni::OpenNI::getExtendedError());
    while (text.ends_with(' ')) text.pop_back();
    return text;
}

/// A name for a recording that OpenNI2 can bear: the file's own, or a link to it in a folder of ours. It is
/// needed only until the file is open.
class BearableName {
  public:
    explicit BearableName(const std::string& file) : name_(file) {
        const bool ascii = std::none_of(file.begin(), file.end(), [](char c) { return (c & 0x80) != 0; });
        bearable_ = ascii && file.size() <= longest_path;
        if (bearable_) return;
        char folder[] = "/tmp/deixis-name-XXXXXX";
        if (mkdtemp(folder) == nullptr) return;
        folder_ = folder;
        std::error_code error;
        const std::string link = folder_ + "/recording.oni";
        std::filesystem::create_symlink(std::filesystem::absolute(file, error), link, error);
        if (error) return;
        name_ = link;
        bearable_ = true;
    }
    BearableName(const BearableName&) = delete;
    BearableName& operator=(const BearableName&) = delete;
    ~BearableName() {
        std::error_code ignored;
        if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
    }
    const std::string& text() const { return name_; }
    /// Nothing could be linked: OpenNI2 must not see the name.
    bool bearable() const { return bearable_; }

  private:
    std::string name_, folder_;
    bool bearable_ = false;
};

std::string size_of(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

class DisconnectWatch : public openni::OpenNI::DeviceDisconnectedListener {
  public:
    void watch(std::string uri) { uri_ = std::move(uri); }
    bool gone() const { return gone_; }

  private:
    void onDeviceDisconnected(const openni::DeviceInfo* info) override {
        if (info != nullptr && uri_ == info->getUri()) gone_ = true;
    }
    std::string uri_;
    std::atomic<bool> gone_{false};
};

}  // namespace

struct OpenniReader::Impl {
    std::string uri;
    bool recording = false;
    int width = 0, height = 0;
    bool initialized = false, started = false, closed = false;
    openni::Device device;
    openni::VideoStream stream;
    openni::VideoFrameRef frame;
    DisconnectWatch disconnect;
    std::string failure;

    Result<void> open_device();
    Result<void> open_recording(int64_t expected_frames);
    Result<void> choose_live_mode();
    Read refuse(const std::string& what) {
        failure = uri + ": " + what;
        return Read::failed;
    }
};

OpenniReader::OpenniReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OpenniReader::OpenniReader(OpenniReader&&) noexcept = default;
OpenniReader& OpenniReader::operator=(OpenniReader&&) noexcept = default;
OpenniReader::~OpenniReader() {
    if (impl_) close();
}

Result<void> OpenniReader::Impl::open_device() {
    if (openni::OpenNI::initialize() != openni::STATUS_OK)
        return fail(uri + ": OpenNI2 does not start: " + openni_reason());
    initialized = true;
    openni::OpenNI::addDeviceDisconnectedListener(&disconnect);
    std::optional<BearableName> file;
    if (recording) {
        file.emplace(uri);
        if (!file->bearable()) return fail(uri + ": cannot be given a name that OpenNI2 can read");
    }
    const char* const name = file ? file->text().c_str() : uri.c_str();
    const bool any = !recording && (uri.empty() || uri == "any");
    if (device.open(any ? openni::ANY_DEVICE : name) != openni::STATUS_OK)
        return fail(uri + ": cannot be opened: " + openni_reason());
    disconnect.watch(device.getDeviceInfo().getUri());
    if (device.isFile() != recording)
        return fail(uri + (recording ? ": is not a recording" : ": is a recording, expected a live device"));
    if (stream.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK)
        return fail(uri + ": has no depth stream: " + openni_reason());
    return {};
}

Result<void> OpenniReader::Impl::open_recording(int64_t expected_frames) {
    openni::PlaybackControl* player = device.getPlaybackControl();
    if (player == nullptr) return fail(uri + ": cannot be played");
    // Speed -1: one frame a request, none lost. Never seek: that hangs or crashes.
    if (player->setSpeed(-1) != openni::STATUS_OK || player->setRepeatEnabled(false) != openni::STATUS_OK)
        return fail(uri + ": cannot be played frame by frame");
    const int frames = player->getNumberOfFrames(stream);
    if (frames != expected_frames)
        return fail(uri + ": OpenNI2 sees " + std::to_string(frames) + " frames, expected " +
                    std::to_string(expected_frames));
    return {};
}

/// Prefers the device's own mode of this size; 30 frames a second if it offers several.
Result<void> OpenniReader::Impl::choose_live_mode() {
    const auto& modes = stream.getSensorInfo().getSupportedVideoModes();
    const openni::VideoMode* best = nullptr;
    for (int i = 0; i < modes.getSize(); ++i) {
        const openni::VideoMode& mode = modes[i];
        if (mode.getResolutionX() != width || mode.getResolutionY() != height ||
            mode.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_1_MM)
            continue;
        if (best == nullptr || (best->getFps() != 30 && mode.getFps() == 30)) best = &mode;
    }
    if (best == nullptr)
        return fail(uri + ": offers no depth of " + size_of(width, height) + " in millimetres");
    if (stream.setVideoMode(*best) != openni::STATUS_OK)
        return fail(uri + ": refuses depth of " + size_of(width, height) + ": " + openni_reason());
    stream.setMirroringEnabled(false);
    if (stream.getMirroringEnabled()) return fail(uri + ": cannot be kept from mirroring its images");
    return {};
}

Result<OpenniReader> OpenniReader::open(const std::string& uri, bool recording, int width, int height,
                                        int64_t expected_frames) {
    OpenniReader reader(std::make_unique<Impl>());
    Impl& m = *reader.impl_;
    m.uri = uri;
    m.recording = recording;
    m.width = width;
    m.height = height;
    auto done = m.open_device();
    if (done) done = recording ? m.open_recording(expected_frames) : m.choose_live_mode();
    if (!done) return tl::unexpected(done.error());
    const openni::VideoMode mode = m.stream.getVideoMode();
    if (mode.getResolutionX() != width || mode.getResolutionY() != height)
        return fail(uri + ": gives " + size_of(mode.getResolutionX(), mode.getResolutionY()) + ", expected " +
                    size_of(width, height));
    if (mode.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_1_MM)
        return fail(uri + ": gives no depth in millimetres");
    if (m.stream.start() != openni::STATUS_OK) return fail(uri + ": does not start: " + openni_reason());
    m.started = true;
    return reader;
}

OpenniReader::Read OpenniReader::read(OpenniFrame& out, std::chrono::milliseconds patience) {
    Impl& m = *impl_;
    if (m.disconnect.gone()) return m.refuse("was disconnected");
    openni::VideoStream* streams[] = {&m.stream};
    int index = -1;
    // readFrame alone would block for ever at the end of a recording or when a device falls silent.
    const openni::Status waited =
        openni::OpenNI::waitForAnyStream(streams, 1, &index, static_cast<int>(patience.count()));
    if (waited == openni::STATUS_TIME_OUT)
        return m.disconnect.gone() ? m.refuse("was disconnected") : Read::nothing;
    if (waited != openni::STATUS_OK) return m.refuse("cannot be waited for: " + openni_reason());
    if (m.stream.readFrame(&m.frame) != openni::STATUS_OK || !m.frame.isValid())
        return m.refuse("cannot be read: " + openni_reason());

    const int width = m.frame.getWidth(), height = m.frame.getHeight(), stride = m.frame.getStrideInBytes();
    if (width != m.width || height != m.height || m.frame.getCroppingEnabled())
        return m.refuse("sends " + size_of(width, height) + ", expected " + size_of(m.width, m.height));
    const size_t row_bytes = static_cast<size_t>(width) * sizeof(uint16_t);
    if (stride < static_cast<int>(row_bytes) ||
        m.frame.getDataSize() < stride * (height - 1) + static_cast<int>(row_bytes))
        return m.refuse("sends frames of " + std::to_string(m.frame.getDataSize()) + " bytes, expected " +
                        std::to_string(row_bytes * height));
    if (m.frame.getTimestamp() > static_cast<uint64_t>(INT64_MAX))
        return m.refuse("sends a stamp beyond 2^63 us");
    out.timestamp_us = static_cast<int64_t>(m.frame.getTimestamp());
    out.millimetres.resize(static_cast<size_t>(width) * height);
    const auto* row = static_cast<const char*>(m.frame.getData());
    for (int v = 0; v < height; ++v, row += stride)
        std::memcpy(out.millimetres.data() + static_cast<size_t>(v) * width, row, row_bytes);
    m.frame.release();
    return Read::frame;
}

const std::string& OpenniReader::failure() const {
    return impl_->failure;
}

void OpenniReader::close() {
    Impl& m = *impl_;
    if (m.closed) return;
    m.closed = true;
    m.frame.release();
    if (m.started) {
        m.stream.stop();
        std::this_thread::sleep_for(after_stop);
    }
    m.stream.destroy();
    m.device.close();
    if (m.initialized) {
        openni::OpenNI::removeDeviceDisconnectedListener(&m.disconnect);
        openni::OpenNI::shutdown();
    }
}

}  // namespace deixis
