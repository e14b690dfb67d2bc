// The defect ledger: the station's own record in one SQLite file. Records in, ids out, each safely on disk
// first.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "appliance/records/defect_record.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// Why the ledger could not do it; `disk_full`, `locked` and `unreachable` may pass, the others will not by
/// waiting.
enum class LedgerTrouble { disk_full, locked, read_only, unreachable, damaged, not_a_ledger, newer, refused };

/// A Failure that says whether waiting helps.
struct LedgerFailure : Failure {
    LedgerTrouble trouble = LedgerTrouble::refused;
};

/// Converts to Result<T> where the cause does not matter.
template <class T>
using LedgerResult = tl::expected<T, LedgerFailure>;

struct LedgerParams {
    int busy_timeout_ms = 2'000;  ///< how long to wait for another process's write, 0 to 60000
    bool check_on_open =
        true;  ///< read every page once before trusting the file (about 0.1 s for 100,000 marks)
    InvalidSettings validate() const;
};

/// All given conditions must hold.
struct DefectFilter {
    std::optional<int64_t> since_us;  ///< time >= since, UTC
    std::optional<int64_t> until_us;  ///< time < until, UTC
    std::optional<std::string> part_type, part_serial, source;
    std::optional<DefectState> state;
    bool undelivered = false;  ///< only those that the PLC has not echoed
    DefectId after = 0;        ///< id > after
    int64_t limit = -1;        ///< at most so many, the oldest first; -1 = all
};

/// What a look at a ledger file shows, see DefectLedger::inspect.
struct LedgerFacts {
    int tables_version = 0;
    bool write_ahead_log = false;
    int64_t defects = 0;
    std::vector<std::string> complaints;  ///< of SQLite's integrity check; empty when all is well
};

/// One connection to one ledger file (WAL, synchronous=FULL, foreign keys on).
/// Threads: every member may be called from any thread; calls on one object take turns. Give a reader that
/// must not delay the writer a ledger object of its own. Processes: many readers and writers at a time.
/// A file that is damaged, foreign or newer is refused and left as it is: the user decides what becomes of
/// it.
class DefectLedger {
  public:
    /// Opens for writing; makes the file where there is none, brings an older schema up to date.
    static LedgerResult<DefectLedger> open(const std::filesystem::path& path,
                                           const LedgerParams& params = {});

    /// Opens an existing file without ever changing it; an older schema is brought up to date in a copy in
    /// memory.
    static LedgerResult<DefectLedger> open_to_read(const std::filesystem::path& path,
                                                   const LedgerParams& params = {});

    /// Reads the whole file without changing it.
    static LedgerResult<LedgerFacts> inspect(const std::filesystem::path& path,
                                             const LedgerParams& params = {});

    DefectLedger(DefectLedger&&) noexcept;
    DefectLedger& operator=(DefectLedger&&) noexcept;
    ~DefectLedger();

    /// Stores a mark (`id` and `delivered_us` of the record are ignored) and returns its id, only after it is
    /// on disk for good. Refused: positions, normals or confidence that are not finite or out of range, a
    /// time outside years 1 to 9999, an empty source, a text of more than 4096 bytes. Texts are kept byte by
    /// byte as given.
    LedgerResult<DefectId> commit(const DefectRecord& record);

    /// Oldest first.
    LedgerResult<std::vector<DefectRecord>> list(const DefectFilter& filter = {}) const;

    LedgerResult<int64_t> count(const DefectFilter& filter = {}) const;

    /// Changes the state and writes the change to the history; on disk when it returns. The same state again
    /// is no change. Refuses an unknown id and an empty `who`.
    LedgerResult<void> set_state(DefectId id, DefectState state, const std::string& who, int64_t time_us);

    /// Every state the defect ever had, oldest first.
    LedgerResult<std::vector<StateChange>> history(DefectId id) const;

    /// Notes that the PLC has echoed the defect; a second note changes nothing. Refuses an unknown id.
    LedgerResult<void> set_delivered(DefectId id, int64_t time_us);

    /// Every line of SQLite's own integrity check; empty when all is well. Reads the whole file.
    LedgerResult<std::vector<std::string>> integrity_complaints() const;

    const std::filesystem::path& path() const;

    static constexpr int schema_version = 2;

    /// "SQLite 3.40.1".
    static std::string library_version();

  private:
    class Connection;
    explicit DefectLedger(std::unique_ptr<Connection> connection);
    std::unique_ptr<Connection> connection_;
};

}  // namespace deixis
