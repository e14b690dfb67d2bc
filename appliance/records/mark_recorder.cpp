// The writer thread takes one mark at a time from the queue's head and drops it from there only once it is on
// disk.
#include "appliance/records/mark_recorder.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace deixis {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

bool may_pass(LedgerTrouble trouble) {
    return trouble == LedgerTrouble::disk_full || trouble == LedgerTrouble::locked ||
           trouble == LedgerTrouble::unreachable;
}

}  // namespace

const char* name_of(RecorderPhase phase) {
    switch (phase) {
        case RecorderPhase::ready:
            return "ready";
        case RecorderPhase::writing:
            return "writing";
        case RecorderPhase::retrying:
            return "retrying";
        case RecorderPhase::failed:
            return "failed";
    }
    return "failed";
}

InvalidSettings MarkRecorderParams::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "queue_length", queue_length, 1, 10'000);
    require_range(complaints, "retry_first_ms", retry_first_ms, 1, 60'000);
    require_range(complaints, "retry_longest_ms", retry_longest_ms, retry_first_ms, 60'000);
    require_range(complaints, "stop_patience_ms", stop_patience_ms, 0, 60'000);
    return complaints;
}

class MarkRecorder::Writer {
  public:
    Writer(DefectLedger& ledger, const MarkRecorderParams& params)
        : ledger_(ledger), params_(params), retry_(params.retry_first_ms), thread_([this] { run(); }) {}

    ~Writer() { stop(); }

    Result<void> post(DefectRecord record) {
        {
            const std::lock_guard lock(mutex_);
            if (stopping_ || marks_.size() >= static_cast<size_t>(params_.queue_length)) {
                ++refused_count_;
                if (stopping_) return fail("the mark is not recorded: the station is stopping");
                return fail("the mark is not recorded: " + std::to_string(marks_.size()) +
                            " marks already wait for the record" +
                            (reason_.empty() ? std::string() : " (" + reason_ + ")"));
            }
            marks_.push_back(std::move(record));
        }
        work_.notify_one();
        return {};
    }

    LedgerResult<DefectId> commit_now(const DefectRecord& record) {
        auto id = ledger_.commit(record);
        const std::lock_guard lock(mutex_);
        if (id) {
            ++committed_count_;
            if (marks_.empty()) succeed();
        } else if (id.error().trouble == LedgerTrouble::refused) {
            ++refused_count_;
        } else {
            note_trouble(id.error());
        }
        return id;
    }

    void note_delivered(DefectId id, int64_t time_us) {
        {
            const std::lock_guard lock(mutex_);
            if (notes_.size() >= static_cast<size_t>(params_.queue_length)) notes_.pop_front();
            notes_.emplace_back(id, time_us);
        }
        work_.notify_one();
    }

    std::vector<DefectRecord> take_committed() {
        const std::lock_guard lock(mutex_);
        return std::exchange(committed_, {});
    }

    std::vector<RefusedMark> take_refused() {
        const std::lock_guard lock(mutex_);
        return std::exchange(refused_, {});
    }

    RecorderState state() const {
        const std::lock_guard lock(mutex_);
        RecorderState now;
        now.phase = trouble_         ? (may_pass(*trouble_) ? RecorderPhase::retrying : RecorderPhase::failed)
                    : marks_.empty() ? RecorderPhase::ready
                                     : RecorderPhase::writing;
        now.reason = reason_;
        now.waiting = static_cast<int>(marks_.size());
        now.committed = committed_count_;
        now.refused = refused_count_;
        return now;
    }

    std::vector<DefectRecord> stop() {
        {
            const std::lock_guard lock(mutex_);
            if (!stopping_) {
                stopping_ = true;
                give_up_at_ = Clock::now() + milliseconds(params_.stop_patience_ms);
            }
        }
        work_.notify_one();
        if (thread_.joinable()) thread_.join();
        const std::lock_guard lock(mutex_);
        std::vector<DefectRecord> left(marks_.begin(), marks_.end());
        marks_.clear();
        return left;
    }

  private:
    void run() {
        std::unique_lock lock(mutex_);
        for (;;) {
            work_.wait(lock, [this] { return stopping_ || !marks_.empty() || !notes_.empty(); });
            const bool idle = marks_.empty() && notes_.empty();
            if (stopping_ && (idle || Clock::now() >= give_up_at_)) return;
            // Marks before notes: a worker waits for the tick, the PLC has its defect already.
            const bool written = marks_.empty() ? write_note(lock) : write_mark(lock);
            if (!written) wait_before_retry(lock);
        }
    }

    /// Only this thread removes from the front, so the front stays where it is while the lock is open.
    bool write_mark(std::unique_lock<std::mutex>& lock) {
        const DefectRecord& front = marks_.front();
        lock.unlock();
        const auto id = ledger_.commit(front);
        lock.lock();
        if (id) {
            DefectRecord done = std::move(marks_.front());
            done.id = *id;
            committed_.push_back(std::move(done));
            ++committed_count_;
        } else if (id.error().trouble == LedgerTrouble::refused) {
            refused_.push_back({std::move(marks_.front()), id.error().sentence});
            ++refused_count_;
        } else {
            note_trouble(id.error());
            return false;
        }
        marks_.pop_front();
        if (id) succeed();
        return true;
    }

    bool write_note(std::unique_lock<std::mutex>& lock) {
        const auto [id, time_us] = notes_.front();
        lock.unlock();
        const auto done = ledger_.set_delivered(id, time_us);
        lock.lock();
        if (!done && done.error().trouble != LedgerTrouble::refused) {
            note_trouble(done.error());
            return false;
        }
        // A full queue may have pushed this note out meanwhile.
        if (!notes_.empty() && notes_.front().first == id) notes_.pop_front();
        succeed();
        return true;
    }

    void succeed() {
        trouble_.reset();
        reason_.clear();
        retry_ = milliseconds(params_.retry_first_ms);
    }

    void note_trouble(const LedgerFailure& failure) {
        trouble_ = failure.trouble;
        reason_ = failure.sentence;
    }

    void wait_before_retry(std::unique_lock<std::mutex>& lock) {
        const milliseconds longest(params_.retry_longest_ms);
        const milliseconds pause = trouble_ && may_pass(*trouble_) ? retry_ : longest;
        retry_ = std::min(retry_ * 2, longest);
        Clock::time_point wake = Clock::now() + pause;
        const bool was_stopping = stopping_;
        if (was_stopping) wake = std::min(wake, give_up_at_);
        work_.wait_until(lock, wake, [&] { return stopping_ != was_stopping; });
    }

    DefectLedger& ledger_;
    const MarkRecorderParams params_;

    mutable std::mutex mutex_;
    std::condition_variable work_;
    std::deque<DefectRecord> marks_;
    std::deque<std::pair<DefectId, int64_t>> notes_;
    std::vector<DefectRecord> committed_;
    std::vector<RefusedMark> refused_;
    std::optional<LedgerTrouble> trouble_;  ///< of the last write
    std::string reason_;
    int64_t committed_count_ = 0, refused_count_ = 0;
    milliseconds retry_;
    bool stopping_ = false;
    Clock::time_point give_up_at_;
    std::thread thread_;  ///< last: it uses all of the above
};

Result<std::unique_ptr<MarkRecorder>> MarkRecorder::start(DefectLedger& ledger,
                                                          const MarkRecorderParams& params) {
    if (const InvalidSettings complaints = params.validate(); !complaints.empty())
        return fail("the setting record." + complaints[0].key + " is " + complaints[0].value + "; expected " +
                    complaints[0].range);
    return std::unique_ptr<MarkRecorder>(new MarkRecorder(std::make_unique<Writer>(ledger, params)));
}

MarkRecorder::MarkRecorder(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}
MarkRecorder::~MarkRecorder() = default;
Result<void> MarkRecorder::post(DefectRecord record) {
    return writer_->post(std::move(record));
}
LedgerResult<DefectId> MarkRecorder::commit_now(const DefectRecord& record) {
    return writer_->commit_now(record);
}
void MarkRecorder::note_delivered(DefectId id, int64_t time_us) {
    writer_->note_delivered(id, time_us);
}
std::vector<DefectRecord> MarkRecorder::take_committed() {
    return writer_->take_committed();
}
std::vector<RefusedMark> MarkRecorder::take_refused() {
    return writer_->take_refused();
}
RecorderState MarkRecorder::state() const {
    return writer_->state();
}
std::vector<DefectRecord> MarkRecorder::stop() {
    return writer_->stop();
}

}  // namespace deixis
