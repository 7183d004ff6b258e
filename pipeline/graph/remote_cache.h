// A cache of actions that a team shares over HTTP, as caches of builds speak it: GET, HEAD and PUT of PREFIX/ac/<SHA-256 of an action> and
// PREFIX/cas/<SHA-256 of a content>.
//
// A record is an ActionResult of Bazel's Remote Execution API. Its output files are the files of the action, and the record of the local
// cache, whose first line is a digest of the action's key. A hit is proved, not trusted: each content is hashed on its way, the record must
// be that of the key, and its files those of the ActionResult. What is read goes into the local cache, from which the executor takes it as
// its own. Contents are written first and the ActionResult last, so that no reader finds one without its contents.
//
// A cook does not get slower. All exchanges run in threads of their own. A cook waits for an answer only as long as answers have taken, and
// for all waits in vain together at most kFreeWait, kWaitShare of its time and kSavedShare of what hits have saved. Then the action runs
// here, beside the request, and the first result wins. Uploads have what is left of the cook, and finish() gives them a little more.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/trace.h"

namespace lightcook::pipeline {

struct RemoteCacheOptions {
    std::string url;
    bool upload = false;
    std::string credentials = {};  ///< see authorizationOf(); empty: none
    double leastWait = 0;          ///< seconds that an action waits for an answer in any case; tests want all answers
    bool isNeeded = false;         ///< waits for every answer and upload, and asks again after failures: a cluster has nothing else
};

/// A content that a job of a cluster needs.
struct SharedContent {
    std::string name;            ///< for messages
    std::string sha256, digest;  ///< names in the remote and in the local cache
    std::uint64_t bytes = 0;
};

/// Figures of one run.
struct RemoteCounts {
    int hits = 0;         ///< actions whose result came from there
    int misses = 0;       ///< actions that it does not have
    int late = 0;         ///< actions that were done here before an answer
    int damaged = 0;      ///< entries that are not what they say
    int failed = 0;       ///< actions that it did not answer about
    int uploaded = 0;     ///< actions
    int refused = 0;      ///< actions whose upload it did not take
    int notUploaded = 0;  ///< actions whose upload had not ended with the cook
    std::uint64_t bytesRead = 0, bytesWritten = 0;
    double lostSeconds = 0;  ///< waits without a hit, of all actions one after the other, and the wait for uploads
    // The first of each kind, in words.
    std::string firstDamage = {}, firstFailure = {}, firstRefusal = {};
};

class RemoteCache {
    class Exchanges;

public:
    /// local  receives what is read, and has what is written
    /// trace  of the exchanges; null: none. Must outlive this
    static formats::Result<std::unique_ptr<RemoteCache>> open(const RemoteCacheOptions& options, Cache local, Trace* trace);
    ~RemoteCache();
    RemoteCache(const RemoteCache&) = delete;
    RemoteCache& operator=(const RemoteCache&) = delete;

    enum class Answer { None, Hit, Miss, Damaged, Failed };

    /// A request for the result of an action. Its destructor ends it.
    class Fetch {
    public:
        Fetch(RemoteCache& cache, const std::string& key, const std::string& id);
        ~Fetch();
        Fetch(const Fetch&) = delete;
        Fetch& operator=(const Fetch&) = delete;

        /// Waits as long as a cook may. After a Hit the local cache has the result.
        Answer wait();
        /// Calls onHit() once a later answer is a hit, from another thread.
        void watch(std::function<void()> onHit);
        /// Ends the request, and returns the answer that came before. No onHit() is called afterwards.
        Answer close();

        struct State;

    private:
        Exchanges& exchanges_;
        std::shared_ptr<State> state_;
    };

    enum class Upload {
        IfMissing,  ///< unless it has a record
        New,        ///< it has no record
        Replace,    ///< also contents that it has: they may be damaged
    };
    /// Writes the result of an action, which the local cache has, in the background. Does nothing without RemoteCacheOptions::upload.
    void upload(const std::string& key, const std::string& id, Upload mode);

    /// Return when they have written or read some contents over one connection, in a thread of their own. Errors of code Internal may pass;
    /// others stay.
    /// files    of the contents, in their order
    /// replace  also contents that it has: they may be damaged
    formats::Result<void> writeContents(const std::vector<SharedContent>& contents, const std::vector<std::filesystem::path>& files,
                                        bool replace, const std::atomic<bool>& interrupted);
    /// Reads them into the local cache, unless that has them.
    formats::Result<void> readContents(const std::vector<SharedContent>& contents, const std::atomic<bool>& interrupted);
    /// Returns a content as text.
    formats::Result<std::string> readText(const std::string& sha256, const std::atomic<bool>& interrupted);

    /// Ends all requests. Uploads have a moment more. Call it once, after the cook.
    RemoteCounts finish();

private:
    explicit RemoteCache(std::unique_ptr<Exchanges> exchanges);
    std::unique_ptr<Exchanges> exchanges_;
};

}  // namespace lightcook::pipeline
