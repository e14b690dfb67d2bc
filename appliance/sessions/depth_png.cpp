// Image files of frames folders and sessions: 16-bit grey and 8-bit PNG, checked before they are decoded.
#include "appliance/sessions/depth_png.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "appliance/calibration/whole_file.h"

namespace deixis {
namespace {

/// What the first 29 bytes of a PNG file claim.
struct PngClaim {
    uint32_t width = 0;
    uint32_t height = 0;
    int bits = 0;
    int colour = 0;  ///< 0 grey, 2 RGB
};

constexpr int grey = 0;
constexpr int rgb = 2;

uint32_t big_endian(const uint8_t* at) {
    return (uint32_t{at[0]} << 24) | (uint32_t{at[1]} << 16) | (uint32_t{at[2]} << 8) | at[3];
}

Result<PngClaim> read_claim(std::span<const uint8_t> file, const std::string& name, ImageSize size) {
    constexpr std::array<uint8_t, 16> start = {0x89, 'P', 'N', 'G', 13,  10,  26,  10,
                                               0,    0,   0,   13,  'I', 'H', 'D', 'R'};
    if (file.size() < 33 || !std::equal(start.begin(), start.end(), file.begin()))
        return fail(name + ": byte 0: expected a PNG file");
    const PngClaim claim = {big_endian(&file[16]), big_endian(&file[20]), file[24], file[25]};
    if (claim.width != static_cast<uint32_t>(size.width) ||
        claim.height != static_cast<uint32_t>(size.height))
        return fail(name + ": expected " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                    " pixels, found " + std::to_string(claim.width) + " x " + std::to_string(claim.height));
    return claim;
}

tl::unexpected<Failure> refuse_kind(const std::string& name, const char* expected, const PngClaim& claim) {
    std::string found = std::to_string(claim.bits) + " bit ";
    found += claim.colour == grey  ? "grey"
             : claim.colour == rgb ? "RGB"
                                   : "of PNG colour type " + std::to_string(claim.colour);
    return fail(name + ": expected " + expected + ", found " + found);
}

/// The pixels as OpenCV decodes them, of exactly the type that the claim promised. OpenCV makes a fourth
/// channel of a tRNS chunk, which names a colour as transparent; the RGB stands in the file all the same.
std::optional<cv::Mat> decode(std::span<const uint8_t> file, const PngClaim& claim, int type) {
    try {
        const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8U, const_cast<uint8_t*>(file.data()));
        cv::Mat image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
        if (claim.colour == rgb && image.type() == CV_8UC4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
        if (image.empty() || image.type() != type || image.cols != static_cast<int>(claim.width) ||
            image.rows != static_cast<int>(claim.height) || !image.isContinuous())
            return std::nullopt;
        return image;
    } catch (const cv::Exception&) {
        return std::nullopt;
    }
}

tl::unexpected<Failure> refuse_damage(const std::string& name) {
    return fail(name + ": expected a whole, undamaged PNG file");
}

std::string pixel_place(const std::string& name, std::ptrdiff_t index, int width) {
    return name + ": pixel (" + std::to_string(index % width) + ", " + std::to_string(index / width) + ")";
}

DepthImage image_of(const cv::Mat& pixels) {
    DepthImage image;
    image.resize(pixels.cols, pixels.rows);
    if (pixels.type() == CV_16U) {
        std::memcpy(image.millimetres.data(), pixels.data, image.millimetres.size() * sizeof(uint16_t));
    } else {
        std::copy_n(pixels.data, image.millimetres.size(), image.millimetres.begin());
    }
    return image;
}

/// No image of that size can be this long; keeps a wrong file from being read whole.
size_t longest_file(ImageSize size) {
    return (size_t{1} << 20) + static_cast<size_t>(size.width) * static_cast<size_t>(size.height) * 8;
}

template <class Image>
Result<Image> read_with(Result<Image> (*decoder)(std::span<const uint8_t>, const std::string&, ImageSize),
                        const std::filesystem::path& path, ImageSize size) {
    const Result<std::string> file = read_whole_file(path, longest_file(size));
    if (!file) return tl::unexpected(file.error());
    return decoder(std::span(reinterpret_cast<const uint8_t*>(file->data()), file->size()), path.string(),
                   size);
}

Result<void> write_png(const cv::Mat& image, const std::filesystem::path& path) {
    std::vector<uint8_t> bytes;
    try {
        if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1}))
            return fail(path.string() + ": cannot be coded as PNG");
    } catch (const cv::Exception&) {
        return fail(path.string() + ": cannot be coded as PNG");
    }
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) return fail(path.string() + ": cannot be written: " + std::strerror(errno));
    return {};
}

}  // namespace

Result<DepthImage> decode_depth_png(std::span<const uint8_t> file, const std::string& name, ImageSize size) {
    const Result<PngClaim> claim = read_claim(file, name, size);
    if (!claim) return tl::unexpected(claim.error());
    if (claim->bits != 16 || claim->colour != grey) return refuse_kind(name, "16 bit grey", *claim);
    const std::optional<cv::Mat> pixels = decode(file, *claim, CV_16UC1);
    if (!pixels) return refuse_damage(name);
    DepthImage image = image_of(*pixels);
    const auto found = std::find(image.millimetres.begin(), image.millimetres.end(), uint16_t{65535});
    if (found == image.millimetres.end()) return image;
    return fail(pixel_place(name, found - image.millimetres.begin(), image.width) +
                ": expected 0 to 65534 mm, found 65535");
}

Result<DepthImage> decode_infrared_png(std::span<const uint8_t> file, const std::string& name,
                                       ImageSize size) {
    const Result<PngClaim> claim = read_claim(file, name, size);
    if (!claim) return tl::unexpected(claim.error());
    if ((claim->bits != 16 && claim->bits != 8) || claim->colour != grey)
        return refuse_kind(name, "8 or 16 bit grey", *claim);
    const std::optional<cv::Mat> pixels = decode(file, *claim, claim->bits == 16 ? CV_16UC1 : CV_8UC1);
    if (!pixels) return refuse_damage(name);
    return image_of(*pixels);
}

Result<VideoImage> decode_video_png(std::span<const uint8_t> file, const std::string& name, ImageSize size) {
    const Result<PngClaim> claim = read_claim(file, name, size);
    if (!claim) return tl::unexpected(claim.error());
    if (claim->bits != 8 || (claim->colour != grey && claim->colour != rgb))
        return refuse_kind(name, "8 bit grey or RGB", *claim);
    const std::optional<cv::Mat> pixels = decode(file, *claim, claim->colour == grey ? CV_8UC1 : CV_8UC3);
    if (!pixels) return refuse_damage(name);
    VideoImage image{pixels->cols, pixels->rows, pixels->channels(), {}};
    cv::Mat ordered = *pixels;
    if (image.channels == 3) cv::cvtColor(*pixels, ordered, cv::COLOR_BGR2RGB);
    image.bytes.assign(ordered.data, ordered.data + ordered.total() * ordered.elemSize());
    if (image.channels == 3) return image;
    const auto found = std::find_if(image.bytes.begin(), image.bytes.end(),
                                    [](uint8_t value) { return value != 0 && value != 255; });
    if (found == image.bytes.end()) return image;
    return fail(pixel_place(name, found - image.bytes.begin(), image.width) +
                ": expected 0 or 255 of a silhouette, found " + std::to_string(*found));
}

Result<DepthImage> read_depth_png(const std::filesystem::path& path, ImageSize size) {
    return read_with(decode_depth_png, path, size);
}

Result<DepthImage> read_infrared_png(const std::filesystem::path& path, ImageSize size) {
    return read_with(decode_infrared_png, path, size);
}

Result<VideoImage> read_video_png(const std::filesystem::path& path, ImageSize size) {
    return read_with(decode_video_png, path, size);
}

Result<void> write_depth_png(const DepthImage& image, const std::filesystem::path& path) {
    return write_png(
        cv::Mat(image.height, image.width, CV_16UC1, const_cast<uint16_t*>(image.millimetres.data())), path);
}

Result<void> write_video_png(const VideoImage& image, const std::filesystem::path& path) {
    const cv::Mat pixels(image.height, image.width, CV_8UC(image.channels),
                         const_cast<uint8_t*>(image.bytes.data()));
    if (image.channels != 3) return write_png(pixels, path);
    cv::Mat ordered;
    cv::cvtColor(pixels, ordered, cv::COLOR_RGB2BGR);
    return write_png(ordered, path);
}

}  // namespace deixis
