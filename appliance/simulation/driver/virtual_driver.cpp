// OpenNI2 driver plug-in of virtual depth sensors. In: the plan that DEIXIS_VIRTUAL_SENSORS names; out:
// devices "virtual://<name>" that can be plugged, pulled and made to misbehave while they run.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)

#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "appliance/sessions/oni_walker.h"
#include "appliance/simulation/driver/virtual_plan.h"
#include "appliance/simulation/driver/virtual_playback.h"

namespace deixis {
namespace {

constexpr const char* plan_variable = "DEIXIS_VIRTUAL_SENSORS";
constexpr std::chrono::milliseconds plan_interval{50};

constexpr int max_depth =
    65535;  ///< above every value that may come: the Recorder replaces what is not below

template <class T>
OniStatus answer(const T& value, void* data, int* size) {
    if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof value);
    *size = sizeof value;
    return ONI_STATUS_OK;
}

/// What driver, device and stream of one virtual sensor share; the behaviour may change at any moment.
struct VirtualPort {
    VirtualSensor sensor;
    OniSummary recording;
    OniVideoMode mode = {};
    OniDeviceInfo info = {};
    std::atomic<VirtualBehaviour> behaviour{VirtualBehaviour::running};
    bool announced = false;  ///< the driver's own
};

/// Answers the properties that OpenNI2's Recorder and player need.
class VirtualStream : public oni::driver::StreamBase {
  public:
    explicit VirtualStream(std::shared_ptr<VirtualPort> port) : port_(std::move(port)) {}

    OniStatus start() override {
        playback_.start(port_->sensor,
                        [this](int64_t due_us, const DepthImage& image) { send(due_us, image); });
        return ONI_STATUS_OK;
    }
    void stop() override { playback_.stop(); }
    OniStatus getProperty(int id, void* data, int* size) override;
    OniStatus setProperty(int id, const void* data, int size) override;
    OniBool isPropertySupported(int id) override;

  private:
    void send(int64_t due_us, const DepthImage& image);

    std::shared_ptr<VirtualPort> port_;
    int frame_index_ = 0;
    int64_t backwards_us_ = 0;
    VirtualPlayback playback_;  ///< last: its thread uses the others
};

void VirtualStream::send(int64_t due_us, const DepthImage& image) {
    const VirtualBehaviour behaviour = port_->behaviour;
    if (behaviour == VirtualBehaviour::silent || behaviour == VirtualBehaviour::unplugged) return;
    OniFrame* frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    const int shrink = behaviour == VirtualBehaviour::small ? 2 : 1;
    frame->videoMode = port_->mode;
    frame->width = image.width / shrink;
    frame->height = image.height / shrink;
    frame->stride = frame->width * static_cast<int>(sizeof(uint16_t));
    frame->dataSize = frame->stride * frame->height;
    frame->sensorType = ONI_SENSOR_DEPTH;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->frameIndex = ++frame_index_;
    int64_t stamp = due_us + port_->sensor.clock_offset_us;
    if (behaviour == VirtualBehaviour::backwards) stamp -= backwards_us_ += 100'000;
    frame->timestamp = static_cast<uint64_t>(std::max<int64_t>(stamp, 0));
    std::memcpy(frame->data, image.millimetres.data(), static_cast<size_t>(frame->dataSize));
    if (behaviour == VirtualBehaviour::garbage) std::memset(frame->data, 0xFF, sizeof(uint16_t));
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
}

OniStatus VirtualStream::getProperty(int id, void* data, int* size) {
    const OniSummary& recording = port_->recording;
    switch (id) {
        case ONI_STREAM_PROPERTY_VIDEO_MODE:
            return answer(port_->mode, data, size);
        case ONI_STREAM_PROPERTY_CROPPING:
            return answer(OniCropping{FALSE, 0, 0, recording.width, recording.height}, data, size);
        case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
            return answer(static_cast<float>(recording.horizontal_fov), data, size);
        case ONI_STREAM_PROPERTY_VERTICAL_FOV:
            return answer(static_cast<float>(recording.vertical_fov), data, size);
        case ONI_STREAM_PROPERTY_MAX_VALUE:
            return answer(max_depth, data, size);
        case ONI_STREAM_PROPERTY_MIN_VALUE:
            return answer(0, data, size);
        case ONI_STREAM_PROPERTY_STRIDE:
            return answer(recording.width * static_cast<int>(sizeof(uint16_t)), data, size);
        case ONI_STREAM_PROPERTY_MIRRORING:
            return answer(OniBool{FALSE}, data, size);
        default:
            return ONI_STATUS_NOT_SUPPORTED;
    }
}

/// One mode, never cropped nor mirrored: anything else is refused.
OniStatus VirtualStream::setProperty(int id, const void* data, int size) {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE && size == sizeof(OniVideoMode))
        return std::memcmp(data, &port_->mode, sizeof(OniVideoMode)) == 0 ? ONI_STATUS_OK
                                                                          : ONI_STATUS_NOT_SUPPORTED;
    if (id == ONI_STREAM_PROPERTY_MIRRORING && size == sizeof(OniBool)) {
        OniBool wanted = FALSE;
        std::memcpy(&wanted, data, sizeof wanted);
        return wanted == FALSE ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    return ONI_STATUS_NOT_SUPPORTED;
}

OniBool VirtualStream::isPropertySupported(int id) {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_CROPPING ||
           id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV || id == ONI_STREAM_PROPERTY_VERTICAL_FOV ||
           id == ONI_STREAM_PROPERTY_MAX_VALUE || id == ONI_STREAM_PROPERTY_MIN_VALUE ||
           id == ONI_STREAM_PROPERTY_STRIDE || id == ONI_STREAM_PROPERTY_MIRRORING;
}

class VirtualDevice : public oni::driver::DeviceBase {
  public:
    explicit VirtualDevice(std::shared_ptr<VirtualPort> port) : port_(std::move(port)) {
        sensor_ = {ONI_SENSOR_DEPTH, 1, &port_->mode};
    }

    OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
        *sensors = &sensor_;
        *count = 1;
        return ONI_STATUS_OK;
    }

    oni::driver::StreamBase* createStream(OniSensorType type) override {
        return type == ONI_SENSOR_DEPTH ? new VirtualStream(port_) : nullptr;
    }

    void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }

  private:
    std::shared_ptr<VirtualPort> port_;
    OniSensorInfo sensor_;
};

class VirtualDriver : public oni::driver::DriverBase {
  public:
    explicit VirtualDriver(OniDriverServices* services) : DriverBase(services) {}
    ~VirtualDriver() override { shutdown(); }

    OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                         oni::driver::DeviceDisconnectedCallback disconnected,
                         oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
        DriverBase::initialize(connected, disconnected, changed, cookie);
        if (std::getenv(plan_variable) == nullptr) return ONI_STATUS_OK;
        follow_plan();
        watcher_ = std::jthread([this](const std::stop_token& stop) {
            while (!stop.stop_requested()) {
                std::this_thread::sleep_for(plan_interval);  // the plan is a file that anyone may rewrite
                follow_plan();
            }
        });
        return ONI_STATUS_OK;
    }

    oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
        std::unique_lock lock(mutex_);
        const auto port = find(uri);
        if (!port || port->behaviour == VirtualBehaviour::unplugged) return nullptr;
        while (port->behaviour == VirtualBehaviour::stuck) {
            lock.unlock();
            std::this_thread::sleep_for(plan_interval);  // hangs, as some drivers do, until the plan frees it
            lock.lock();
        }
        return new VirtualDevice(port);
    }

    void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

    void shutdown() override {
        watcher_.request_stop();
        if (watcher_.joinable()) watcher_.join();
    }

  private:
    std::shared_ptr<VirtualPort> find(const std::string& uri) {
        for (const auto& port : ports_)
            if (uri == port->info.uri) return port;
        return nullptr;
    }

    void follow_plan();
    std::shared_ptr<VirtualPort> add(const VirtualSensor& sensor);

    std::mutex mutex_;
    std::vector<std::shared_ptr<VirtualPort>> ports_;
    std::filesystem::file_time_type plan_written_;
    std::string last_complaint_;
    std::jthread watcher_;
};

std::shared_ptr<VirtualPort> VirtualDriver::add(const VirtualSensor& sensor) {
    const auto head = walk_oni(sensor.recording, OniPixels::skipped);
    if (!head) return nullptr;
    auto port = std::make_shared<VirtualPort>();
    port->sensor = sensor;
    port->recording = *head;
    port->mode = {ONI_PIXEL_FORMAT_DEPTH_1_MM, head->width, head->height, head->fps};
    std::snprintf(port->info.uri, sizeof port->info.uri, "virtual://%s", sensor.name.c_str());
    std::snprintf(port->info.vendor, sizeof port->info.vendor, "Deixis");
    std::snprintf(port->info.name, sizeof port->info.name, "Virtual depth sensor %s", sensor.name.c_str());
    ports_.push_back(port);
    return port;
}

/// Reads the plan when it has changed; tells OpenNI2 who came and who went.
void VirtualDriver::follow_plan() {
    const std::filesystem::path source = std::getenv(plan_variable);
    std::error_code error;
    const auto written = std::filesystem::last_write_time(source, error);
    if (error || written == plan_written_) return;
    const auto plan = read_virtual_plan(source);
    if (!plan) {
        // A plan in the middle of being written is read again next time; the devices stay as they are.
        if (plan.error().sentence != last_complaint_)
            getServices().errorLoggerAppend("%s", plan.error().sentence.c_str());
        last_complaint_ = plan.error().sentence;
        return;
    }
    plan_written_ = written;
    std::vector<std::shared_ptr<VirtualPort>> came, went;
    {
        const std::lock_guard lock(mutex_);
        for (const VirtualSensor& sensor : *plan) {
            auto port = find("virtual://" + sensor.name);
            if (!port) port = add(sensor);
            if (!port) continue;
            port->behaviour = sensor.behaviour;
            const bool plugged = sensor.behaviour != VirtualBehaviour::unplugged;
            if (plugged != port->announced) (plugged ? came : went).push_back(port);
            port->announced = plugged;
        }
    }
    // Outside the lock: the application may open a device from within the callback.
    for (const auto& port : came) deviceConnected(&port->info);
    for (const auto& port : went) deviceDisconnected(&port->info);
}

}  // namespace
}  // namespace deixis

ONI_EXPORT_DRIVER(deixis::VirtualDriver)
