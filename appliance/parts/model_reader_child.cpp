// The child's end of the model reader: limits first, then the file, then one reply.
#include "appliance/parts/model_reader_child.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <new>
#include <string>
#include <vector>

#include "appliance/parts/model_file.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DEIXIS_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define DEIXIS_SANITIZED 1
#endif
#endif

namespace deixis {
namespace {

void limit(__rlimit_resource resource, rlim_t amount) {
    const rlimit both = {amount, amount};
    setrlimit(resource, &both);
}

/// Writes all of it; false when nobody listens any more.
bool write_all(int file, const void* data, size_t size) {
    const char* next = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t written = write(file, next, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        next += written;
        size -= static_cast<size_t>(written);
    }
    return true;
}

bool reply(int file, const std::string& sentence) {
    ModelReplyHead head;
    head.sentence = sentence.size();
    return write_all(file, &head, sizeof head) && write_all(file, sentence.data(), sentence.size());
}

bool reply(int file, const SurfaceMesh& mesh) {
    ModelReplyHead head;
    head.vertices = mesh.vertices.size();
    head.triangles = mesh.triangles.size();
    return write_all(file, &head, sizeof head) &&
           write_all(file, mesh.vertices.data(), mesh.vertices.size() * sizeof mesh.vertices[0]) &&
           write_all(file, mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
}

int reply_file_when_full = -1;
std::string& sentence_when_full() {
    static std::string sentence;
    return sentence;
}

/// Memory is at its end: the sentence was made before, and there is nothing to go on with.
void on_memory_full() {
    reply(reply_file_when_full, sentence_when_full());
    _exit(0);
}

void hold_limits(const ModelRequest& request) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    limit(RLIMIT_CORE, 0);
    // A second line: the parent counts wall time, and this holds when the parent is gone. Two cores at most.
    limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(request.limits.time_limit_s)) * 2 + 1);
#ifndef DEIXIS_SANITIZED
    limit(RLIMIT_AS, static_cast<rlim_t>(request.limits.memory_limit_mb) << 20);
#endif
    reply_file_when_full = request.reply_file;
    sentence_when_full() = request.model.string() + ": reading it takes more than " +
                           std::to_string(request.limits.memory_limit_mb) +
                           " MB of memory; is the file damaged, or far too fine?";
    std::set_new_handler(on_memory_full);
}

}  // namespace

void run_model_reader(const ModelRequest& request) {
    hold_limits(request);
    const Result<SurfaceMesh> mesh = read_model_file(request.model, request.metres_per_unit);
    const bool told =
        mesh ? reply(request.reply_file, *mesh) : reply(request.reply_file, mesh.error().sentence);
    // No destructors: what the libraries left behind must not spoil a good reply.
    _exit(told ? 0 : 1);
}

}  // namespace deixis
