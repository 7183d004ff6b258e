#include "pipeline/graph/remote_cache.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <fstream>
#include <future>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>
#include <vector>

#include "formats/pending_file.h"
#include "pipeline/graph/action_result.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/http_client.h"
#include "pipeline/graph/sha256.h"

namespace lightcook::pipeline {
namespace {

using Clock = std::chrono::steady_clock;

/// Waits in vain that a cook may lose: seconds, a share of its time, and a share of what hits have saved. That was measured where the
/// actions ran, perhaps on a slower machine.
constexpr double kFreeWait = 0.02, kWaitShare = 0.015, kSavedShare = 0.125;
/// Waits for uploads after a cook: seconds, or a share of its time if that is more; kLastMoment if the server has taken nothing yet.
constexpr double kUploadWait = 0.5, kUploadShare = 0.03, kLastMoment = 0.05;
constexpr int kMostFailures = 3;  ///< in a row: then the server is not asked again
constexpr std::size_t kThreads = 8;

constexpr std::uint64_t kMostResultBytes = 4 << 20, kMostRecordBytes = 64 << 20;
/// The output file of an ActionResult that is the record of the local cache.
constexpr const char* kRecordPath = "lightcook.record";

/// Returns the key that a team shares. Another compiler comes with other versions of the libraries, which may encode otherwise.
std::string sharedKey(const std::string& key) {
    return sha256OfText(fmt::format("lightcook action {} {}", key, __VERSION__));
}

/// Lets this thread write into sockets that the server may have closed, as OpenSSL does.
void blockBrokenPipes() {
    sigset_t broken;
    sigemptyset(&broken);
    sigaddset(&broken, SIGPIPE);
    ::pthread_sigmask(SIG_BLOCK, &broken, nullptr);
}

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

struct RemoteCache::Fetch::State {
    std::string key, id;
    Clock::time_point start = Clock::now();
    std::atomic<bool> isClosed{false};
    // Guarded by the mutex of the cache.
    Answer answer = Answer::None;
    std::function<void()> onHit = {};
};

/// The threads that talk to the server, and what they have to do.
class RemoteCache::Exchanges {
public:
    using State = Fetch::State;

    Exchanges(const RemoteCacheOptions& options, const HttpUrl& url, Cache local, Trace* trace)
        : url_(options.url),
          mayUpload_(options.upload),
          isNeeded_(options.isNeeded),
          leastWait_(options.leastWait),
          local_(std::move(local)),
          trace_(trace),
          server_(url, options.credentials.empty() ? "" : authorizationOf(options.credentials)) {}
    ~Exchanges() { end(); }
    Exchanges(const Exchanges&) = delete;
    Exchanges& operator=(const Exchanges&) = delete;

    void startRead(const std::shared_ptr<State>& fetch) {
        const std::lock_guard lock(mutex_);
        if (isGivenUp_ || isEnding_) {
            ++counts_.failed;
            fetch->answer = Answer::Failed;
            return;
        }
        reads_.push_back(fetch);
        wakeLocked();
    }

    Answer wait(State& fetch) {
        std::unique_lock lock(mutex_);
        const double left = kFreeWait + kWaitShare * secondsSince(start_) + kSavedShare * savedSeconds_ - wastedSeconds_;
        const Clock::time_point start = Clock::now();
        const std::chrono::duration<double> most(std::max(leastWait_, std::min(2 * meanAnswer_, left)));
        const auto hasAnswer = [&] { return fetch.answer != Answer::None; };
        isNeeded_ ? changed_.wait(lock, hasAnswer) : (void)changed_.wait_for(lock, most, hasAnswer);
        if (fetch.answer != Answer::Hit) wastedSeconds_ += secondsSince(start);
        const Answer answer = fetch.answer;
        lock.unlock();
        if (trace_ != nullptr) trace_->add("wait for the remote cache", "wait", start, {{"action", fetch.id}});
        return answer;
    }

    void watch(State& fetch, std::function<void()> onHit) {
        const std::lock_guard lock(mutex_);
        if (fetch.answer == Answer::Hit)
            onHit();
        else
            fetch.onHit = std::move(onHit);
    }

    Answer close(State& fetch) {
        const std::lock_guard lock(mutex_);
        fetch.onHit = {};
        if (!fetch.isClosed.exchange(true) && fetch.answer == Answer::None) ++counts_.late;
        return fetch.answer;
    }

    void startWrite(const std::string& key, const std::string& id, Upload mode) {
        const std::lock_guard lock(mutex_);
        if (!mayUpload_ || isEnding_ || !written_.insert(key).second) return;
        writes_.push_back({key, id, mode});
        wakeLocked();
    }

    RemoteCounts finish() {
        {
            std::unique_lock lock(mutex_);
            const auto isDone = [&] { return writes_.empty() && runningWrites_ == 0; };
            const auto wait = [&](double seconds) { changed_.wait_for(lock, std::chrono::duration<double>(seconds), isDone); };
            const double most = std::max(kUploadWait, kUploadShare * secondsSince(start_));
            const Clock::time_point start = Clock::now();
            if (isNeeded_)
                changed_.wait(lock, isDone);
            else
                wait(kLastMoment);
            if (hasTaken_ && !isGivenUp_) wait(most - kLastMoment);
            counts_.lostSeconds = wastedSeconds_ + secondsSince(start);
        }
        end();
        counts_.notUploaded += static_cast<int>(writes_.size());
        return counts_;
    }

    /// Calls exchange(connection) in a thread of its own, until it is done or the run is interrupted.
    template <class Exchange>
    auto inThread(const std::atomic<bool>& interrupted, Exchange exchange) {
        return std::async(std::launch::async,
                          [&] {
                              blockBrokenPipes();
                              HttpConnection connection(server_, [&] { return isEnding_ || interrupted; });
                              return exchange(connection);
                          })
            .get();
    }

    formats::Result<void> writeNow(const std::string& name, const OutputFile& file, std::istream& body, bool replace,
                                   HttpConnection& connection) {
        std::string why;
        const Write write{{}, name, replace ? Upload::Replace : Upload::New};
        const Answer answer = writeContent(write, file, body, connection, why);
        if (answer == Answer::Hit) return {};
        const bool isRefused = answer == Answer::Damaged;
        return formats::failure(isRefused ? formats::ErrorCode::InvalidRequest : formats::ErrorCode::Internal, url_,
                                fmt::format("found that {} cannot be written there ({}), expected a cache that takes it{}", name, why,
                                            isRefused ? ": see --remote-credentials" : ""));
    }

    formats::Result<void> readNow(const SharedContent& content, HttpConnection& connection) {
        const std::string fault = readContent(content.name, content, connection);
        if (fault.empty()) return {};
        return formats::failure(formats::ErrorCode::Internal, url_, fmt::format("found that {}, expected it in the remote cache", fault));
    }

    formats::Result<std::string> readTextNow(const std::string& sha256, HttpConnection& connection) {
        std::string text;
        const HttpResult got = get(connection, sha256, "cas/" + sha256, kMostRecordBytes, text);
        if (got && got->status == 200 && sha256OfText(text) == sha256) return text;
        return formats::failure(formats::ErrorCode::Internal, url_,
                                fmt::format("found that cas/{} is {}, expected it in the remote cache", sha256, faultOf(got)));
    }

private:
    struct Write {
        std::string key, id;
        Upload mode;
    };

    /// Starts a thread if no thread waits for the new job.
    void wakeLocked() {
        if (idleThreads_ < reads_.size() + writes_.size() && threads_.size() < kThreads) threads_.emplace_back([this] { work(); });
        changed_.notify_all();
    }

    void end() {
        {
            const std::lock_guard lock(mutex_);
            isEnding_ = true;
            changed_.notify_all();
        }
        for (std::thread& thread : threads_) thread.join();
        threads_.clear();
    }

    void work() {
        blockBrokenPipes();
        std::shared_ptr<State> fetch;
        HttpConnection connection(server_, [&] { return isEnding_ || (fetch != nullptr && fetch->isClosed); });
        std::unique_lock lock(mutex_);
        while (true) {
            ++idleThreads_;
            changed_.wait(lock, [&] { return isEnding_ || !reads_.empty() || !writes_.empty(); });
            --idleThreads_;
            if (isEnding_) return;
            if (!reads_.empty()) {
                fetch = std::move(reads_.front());
                reads_.pop_front();
                lock.unlock();
                if (!fetch->isClosed) read(*fetch, connection);
                fetch = nullptr;
                lock.lock();
            } else {
                const Write write = std::move(writes_.front());
                writes_.pop_front();
                ++runningWrites_;
                lock.unlock();
                this->write(write, connection);
                lock.lock();
                --runningWrites_;
                changed_.notify_all();
            }
        }
    }

    // --- reading ------------------------------------------------------------------------------------------------------------------------

    void read(State& fetch, HttpConnection& connection) {
        std::string why;
        double saved = 0;
        const Answer answer = tryRead(fetch, connection, why, saved);
        const std::lock_guard lock(mutex_);
        if (fetch.isClosed || isEnding_) return;
        fetch.answer = answer;
        switch (answer) {
            case Answer::Hit:
                ++counts_.hits;
                savedSeconds_ += std::max(0.0, saved - secondsSince(fetch.start));
                if (fetch.onHit) fetch.onHit();
                break;
            case Answer::Damaged:
                if (counts_.damaged++ == 0) counts_.firstDamage = why;
                break;
            case Answer::Failed:
                if (counts_.failed++ == 0) counts_.firstFailure = why;
                break;
            default:
                ++counts_.misses;
        }
        noteLocked(answer != Answer::Failed);
        if (answer == Answer::Hit || answer == Answer::Miss) meanAnswer_ += 0.3 * (secondsSince(fetch.start) - meanAnswer_);
        changed_.notify_all();
    }

    void noteLocked(bool hasAnswered) {
        failuresInARow_ = hasAnswered ? 0 : failuresInARow_ + 1;
        isGivenUp_ = isGivenUp_ || (!isNeeded_ && failuresInARow_ >= kMostFailures);
    }

    /// Reads a result into the local cache.
    /// why    it is not a hit
    /// saved  seconds that the action took where it ran
    Answer tryRead(const State& fetch, HttpConnection& connection, std::string& why, double& saved) {
        const std::string path = "ac/" + sharedKey(fetch.key);
        std::string text;
        const HttpResult answer = get(connection, fetch.id, path, kMostResultBytes, text);
        if (!answer || (!answer->isGood() && answer->status != 404)) {
            why = answer ? fmt::format("{}: status {}", path, answer->status) : fmt::format("{}: {}", path, answer.error());
            return Answer::Failed;
        }
        if (answer->status != 200) return Answer::Miss;
        const auto damaged = [&](const std::string& what) {
            why = fmt::format("{}: {}", path, what);
            return Answer::Damaged;
        };
        const auto outputs = readActionResult(text);
        if (!outputs) return damaged("no ActionResult with an output file");
        const auto outputOf = [&](const std::string& name) {
            return std::find_if(outputs->begin(), outputs->end(), [&](const OutputFile& each) { return each.path == name; });
        };
        const auto recorded = outputOf(kRecordPath);
        if (recorded == outputs->end() || recorded->bytes > kMostRecordBytes) return damaged("no record of lightcook");
        std::string recordText;
        const HttpResult got = get(connection, fetch.id, "cas/" + recorded->sha256, recorded->bytes, recordText);
        if (!got || got->status != 200 || sha256OfText(recordText) != recorded->sha256) return damaged("its record is " + faultOf(got));
        const auto record = Cache::parse(fetch.key, recordText);
        if (!record) return damaged("the record of another action");
        for (const FileRecord& file : record->files) {
            const auto output = outputOf(file.name);
            if (output == outputs->end() || output->bytes != file.bytes)
                return damaged(fmt::format("its files are not those of its record ({})", file.name));
            const SharedContent content{file.name, output->sha256, file.digest, output->bytes};
            if (const std::string fault = readContent(fetch.id, content, connection); !fault.empty()) return damaged(fault);
        }
        if (const auto written = writeFile(local_.recordPath(fetch.key), recordText); !written) {
            why = written.error().line();
            return Answer::Failed;
        }
        saved = record->seconds;
        return Answer::Hit;
    }

    static std::string faultOf(const HttpResult& got) {
        return !got                 ? "not to be had: " + got.error()
               : got->status == 404 ? "missing"
               : got->status == 200 ? "another content"
                                    : fmt::format("not to be had: status {}", got->status);
    }

    /// Reads a content into the local cache, unless that has it. Returns what is wrong with it.
    /// reader   the action, for the trace
    std::string readContent(const std::string& reader, const SharedContent& content, HttpConnection& connection) {
        const std::filesystem::path place = local_.contentPath(content.digest);
        if (content.bytes > kCacheLimitBytes) return fmt::format("{} is larger than a cache", content.name);
        std::error_code code;
        if (std::filesystem::is_regular_file(place, code) && sizeOf(place) == content.bytes) return {};
        if (const auto made = makeFolder(place.parent_path()); !made) return made.error().line();
        auto pending = formats::PendingFile::create(place);
        if (!pending) return pending.error().line();
        std::ofstream stream(pending->temporary(), std::ios::binary);
        Sha256 digest;
        bool isFull = false;
        const HttpResult got = get(connection, reader, "cas/" + content.sha256, content.bytes, [&](std::string_view piece) {
            digest.add(piece);
            isFull = !stream.write(piece.data(), static_cast<std::streamsize>(piece.size()));
            return !isFull;
        });
        stream.close();
        if (isFull || !stream) return fmt::format("{} cannot be written into the cache folder {}", content.name, local_.root().string());
        if (!got || got->status != 200 || digest.hex() != content.sha256) return fmt::format("{} is {}", content.name, faultOf(got));
        // The record says so too, and the local cache trusts it.
        if (const auto found = digestOfFile(pending->temporary()); !found || *found != content.digest)
            return content.name + " is another content";
        const auto written = pending->commit();
        return written ? "" : written.error().line();
    }

    HttpResult get(HttpConnection& connection, const std::string& id, const std::string& path, std::uint64_t limit,
                   const HttpConnection::Sink& sink) {
        const Clock::time_point start = Clock::now();
        std::uint64_t bytes = 0;
        HttpResult result = connection.get(path, limit, [&](std::string_view piece) {
            bytes += piece.size();
            return sink(piece);
        });
        {
            const std::lock_guard lock(mutex_);
            counts_.bytesRead += bytes;
        }
        trace("GET " + path, "remote read", id, start, result, bytes);
        return result;
    }
    HttpResult get(HttpConnection& connection, const std::string& id, const std::string& path, std::uint64_t limit, std::string& text) {
        return get(connection, id, path, limit, [&](std::string_view piece) {
            text += piece;
            return true;
        });
    }

    // --- writing ------------------------------------------------------------------------------------------------------------------------

    void write(const Write& write, HttpConnection& connection) {
        {
            const std::lock_guard lock(mutex_);
            if (isGivenUp_ || (!isNeeded_ && refusalsInARow_ >= kMostFailures)) {
                ++(isGivenUp_ ? counts_.notUploaded : counts_.refused);
                return;
            }
        }
        std::string why;
        const Answer answer = tryWrite(write, connection, why);
        const std::lock_guard lock(mutex_);
        switch (answer) {
            case Answer::Hit:
                ++counts_.uploaded;
                break;
            case Answer::Damaged:
                if (counts_.refused++ == 0) counts_.firstRefusal = why;
                break;
            case Answer::Failed:
                ++counts_.notUploaded;
                if (!isEnding_ && counts_.firstFailure.empty()) counts_.firstFailure = why;
                break;
            default:
                break;
        }
        if (isEnding_) return;
        refusalsInARow_ = answer == Answer::Damaged ? refusalsInARow_ + 1 : 0;
        noteLocked(answer != Answer::Failed);
    }

    /// Returns Hit: written. Miss: there is nothing to write. Damaged: refused. Failed: no answer.
    Answer tryWrite(const Write& write, HttpConnection& connection, std::string& why) {
        const std::string path = "ac/" + sharedKey(write.key);
        if (write.mode == Upload::IfMissing) {
            const auto found = connection.head(path);
            if (!found) {
                why = fmt::format("HEAD {}: {}", path, found.error());
                return Answer::Failed;
            }
            noteTaken();
            if (found->status == 200) return Answer::Miss;
        }
        // The local cache may have dropped it since.
        const auto text = readFile(local_.recordPath(write.key));
        const auto record = text ? Cache::parse(write.key, *text) : std::nullopt;
        if (!record) return Answer::Miss;
        std::istringstream recordStream(*text);
        std::vector<OutputFile> outputs = {{kRecordPath, sha256OfText(*text), text->size()}};
        if (const Answer answer = writeContent(write, outputs[0], recordStream, connection, why); answer != Answer::Hit) return answer;
        for (const FileRecord& file : record->files) {
            const std::filesystem::path content = local_.contentPath(file.digest);
            const auto digest = sha256OfFile(content);
            if (!digest) return Answer::Miss;
            std::ifstream stream(content, std::ios::binary);
            outputs.push_back({file.name, *digest, sizeOf(content)});
            if (const Answer answer = writeContent(write, outputs.back(), stream, connection, why); answer != Answer::Hit) return answer;
        }
        const std::string result = actionResultText(outputs);
        std::istringstream stream(result);
        return put(write, path, stream, result.size(), connection, why);
    }

    Answer writeContent(const Write& write, const OutputFile& file, std::istream& body, HttpConnection& connection, std::string& why) {
        const std::string path = "cas/" + file.sha256;
        if (write.mode != Upload::Replace) {
            const auto found = connection.head(path);
            if (found && found->status == 200 && found->length == file.bytes) return Answer::Hit;
        }
        return put(write, path, body, file.bytes, connection, why);
    }

    Answer put(const Write& write, const std::string& path, std::istream& body, std::uint64_t bytes, HttpConnection& connection,
               std::string& why) {
        const Clock::time_point start = Clock::now();
        const HttpResult result = connection.put(path, body, bytes);
        trace("PUT " + path, "remote write", write.id, start, result, bytes);
        if (!result) {
            why = fmt::format("PUT {}: {}", path, result.error());
            return Answer::Failed;
        }
        if (!result->isGood()) {
            why = fmt::format("PUT {}: status {}", path, result->status);
            return Answer::Damaged;
        }
        noteTaken();
        const std::lock_guard lock(mutex_);
        counts_.bytesWritten += bytes;
        return Answer::Hit;
    }

    /// Notes that the server answers.
    void noteTaken() {
        const std::lock_guard lock(mutex_);
        hasTaken_ = true;
    }

    void trace(const std::string& name, const char* category, const std::string& id, Clock::time_point start, const HttpResult& result,
               std::uint64_t bytes) const {
        if (trace_ == nullptr) return;
        Json arguments = {{"action", id}, {"bytes", bytes}};
        result ? arguments["status"] = result->status : arguments["failure"] = result.error();
        trace_->add(name, category, start, arguments);
    }

    const std::string url_;
    const bool mayUpload_, isNeeded_;
    const double leastWait_;
    const Cache local_;
    Trace* const trace_;
    const HttpServer server_;
    const Clock::time_point start_ = Clock::now();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::shared_ptr<State>> reads_;
    std::deque<Write> writes_;
    std::set<std::string> written_;  ///< keys whose upload began
    std::vector<std::thread> threads_;
    std::size_t idleThreads_ = 0;
    int runningWrites_ = 0, failuresInARow_ = 0, refusalsInARow_ = 0;
    bool hasTaken_ = false;   ///< it has answered to an upload
    bool isGivenUp_ = false;  ///< after kMostFailures
    std::atomic<bool> isEnding_{false};
    double meanAnswer_ = 0.1;  ///< time until an answer [s]
    double wastedSeconds_ = 0, savedSeconds_ = 0;
    RemoteCounts counts_;
};

RemoteCache::RemoteCache(std::unique_ptr<Exchanges> exchanges) : exchanges_(std::move(exchanges)) {}
RemoteCache::~RemoteCache() = default;

formats::Result<std::unique_ptr<RemoteCache>> RemoteCache::open(const RemoteCacheOptions& options, Cache local, Trace* trace) {
    LC_TRY(url, parseHttpUrl(options.url));
    return std::unique_ptr<RemoteCache>(new RemoteCache(std::make_unique<Exchanges>(options, *url, std::move(local), trace)));
}

RemoteCache::Fetch::Fetch(RemoteCache& cache, const std::string& key, const std::string& id)
    : exchanges_(*cache.exchanges_), state_(std::make_shared<State>()) {
    state_->key = key;
    state_->id = id;
    exchanges_.startRead(state_);
}
RemoteCache::Fetch::~Fetch() {
    exchanges_.close(*state_);
}
RemoteCache::Answer RemoteCache::Fetch::wait() {
    return exchanges_.wait(*state_);
}
void RemoteCache::Fetch::watch(std::function<void()> onHit) {
    exchanges_.watch(*state_, std::move(onHit));
}
RemoteCache::Answer RemoteCache::Fetch::close() {
    return exchanges_.close(*state_);
}

void RemoteCache::upload(const std::string& key, const std::string& id, Upload mode) {
    exchanges_->startWrite(key, id, mode);
}

formats::Result<void> RemoteCache::writeContents(const std::vector<SharedContent>& contents,
                                                 const std::vector<std::filesystem::path>& files, bool replace,
                                                 const std::atomic<bool>& interrupted) {
    return exchanges_->inThread(interrupted, [&](HttpConnection& connection) -> formats::Result<void> {
        for (std::size_t i = 0; i < contents.size(); ++i) {
            std::ifstream body(files[i], std::ios::binary);
            LC_CHECK(exchanges_->writeNow(contents[i].name, {contents[i].name, contents[i].sha256, contents[i].bytes}, body, replace,
                                          connection));
        }
        return {};
    });
}
formats::Result<void> RemoteCache::readContents(const std::vector<SharedContent>& contents, const std::atomic<bool>& interrupted) {
    return exchanges_->inThread(interrupted, [&](HttpConnection& connection) -> formats::Result<void> {
        for (const SharedContent& content : contents) LC_CHECK(exchanges_->readNow(content, connection));
        return {};
    });
}
formats::Result<std::string> RemoteCache::readText(const std::string& sha256, const std::atomic<bool>& interrupted) {
    return exchanges_->inThread(interrupted, [&](HttpConnection& connection) { return exchanges_->readTextNow(sha256, connection); });
}

RemoteCounts RemoteCache::finish() {
    return exchanges_->finish();
}

}  // namespace lightcook::pipeline
