// Between frame loop and ledger: a bounded queue and one writer thread. Marks in, committed marks with ids
// out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "appliance/records/defect_ledger.h"

namespace deixis {

struct MarkRecorderParams {
    int queue_length = 64;         ///< marks that may wait for the disk, 1 to 10000
    int retry_first_ms = 50;       ///< first wait after a full or locked disk, 1 to 60000
    int retry_longest_ms = 2'000;  ///< the waits double up to this, retry_first_ms to 60000
    int stop_patience_ms = 3'000;  ///< stop() goes on trying for so long, 0 to 60000
    InvalidSettings validate() const;
};

enum class RecorderPhase {
    ready,     ///< nothing waits, the last write went well
    writing,   ///< marks wait, the last write went well
    retrying,  ///< the ledger cannot write now; marks wait and are tried again
    failed,    ///< the ledger is broken (damaged, read-only...): marks wait, tried again at the longest
               ///< interval
};

/// "ready", "writing", "retrying" or "failed".
const char* name_of(RecorderPhase phase);

struct RecorderState {
    RecorderPhase phase = RecorderPhase::ready;
    std::string reason;     ///< one sentence when retrying or failed
    int waiting = 0;        ///< posted, not yet committed
    int64_t committed = 0;  ///< since start
    int64_t refused = 0;    ///< since start: posts refused because the queue was full, or by the ledger
};

/// A mark that will not be recorded, and why. It was never acknowledged.
struct RefusedMark {
    DefectRecord record;
    std::string sentence;
};

/// Threads: all members from any thread. `ledger` must outlive this object; the writer thread holds it only
/// while it commits.
class MarkRecorder {
  public:
    /// Starts the writer thread. Refuses bad params by name.
    static Result<std::unique_ptr<MarkRecorder>> start(DefectLedger& ledger,
                                                       const MarkRecorderParams& params = {});
    ~MarkRecorder();  ///< as stop()

    /// Queues a mark; never waits for the disk. A full queue refuses the new mark with a sentence, counts it,
    /// and returns the failure to the caller, who must not acknowledge it: nothing already waiting is
    /// dropped.
    Result<void> post(DefectRecord record);

    /// Commits in the caller's thread: for lock-step replay. No retry.
    LedgerResult<DefectId> commit_now(const DefectRecord& record);

    /// Notes for the ledger that the PLC has echoed a defect; never waits. The oldest notes go first when
    /// more than `queue_length` wait: such a defect is then delivered again after a restart, which
    /// at-least-once allows.
    void note_delivered(DefectId id, int64_t time_us);

    /// Marks committed since the last call, in order, with their ids: acknowledge these, and only these.
    std::vector<DefectRecord> take_committed();

    /// Marks that the ledger itself refused (a bad value), since the last call.
    std::vector<RefusedMark> take_refused();

    RecorderState state() const;

    /// Writes what waits, within stop_patience_ms, ends the thread, and returns what could not be written.
    std::vector<DefectRecord> stop();

    MarkRecorder(const MarkRecorder&) = delete;
    MarkRecorder& operator=(const MarkRecorder&) = delete;

  private:
    class Writer;
    explicit MarkRecorder(std::unique_ptr<Writer> writer);
    std::unique_ptr<Writer> writer_;
};

}  // namespace deixis
