// Lines of results, renamed into place at the end.
#include "appliance/commands/results_writer.h"

namespace deixis {

ResultsWriter::ResultsWriter(std::filesystem::path path, std::filesystem::path partial, std::ofstream lines)
    : path_(std::move(path)), partial_(std::move(partial)), lines_(std::move(lines)) {}

Result<ResultsWriter> ResultsWriter::create(const std::filesystem::path& path) {
    std::filesystem::path partial = path;
    partial += ".partial";
    std::ofstream lines(partial, std::ios::binary | std::ios::trunc);
    if (!lines) return fail(partial.string() + ": cannot be written");
    return ResultsWriter(path, std::move(partial), std::move(lines));
}

void ResultsWriter::add(const FrameResult& result) {
    lines_ << to_json(result).dump() << '\n';
}

Result<void> ResultsWriter::finish() {
    if (!lines_.flush()) return fail("the results cannot be written, the disk is full or gone");
    lines_.close();
    std::error_code error;
    std::filesystem::rename(partial_, path_, error);
    if (error) return fail(path_.string() + ": cannot be written");
    return {};
}

}  // namespace deixis
