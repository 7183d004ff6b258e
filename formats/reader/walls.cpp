#include "formats/reader/walls.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <fstream>
#include <iterator>

namespace lightcook::formats {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // they reserve terabytes, and write their reports to files
#elif defined(__has_feature)
constexpr bool kIsSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kIsSanitized = false;
#endif

bool limit(__rlimit_resource resource, std::uint64_t most) {
    const rlimit both{most, most};
    return ::setrlimit(resource, &both) == 0;
}

bool limitResources(std::uint64_t memoryBytes) {
    constexpr std::uint64_t kMostCpuSeconds = 4 * 3600, kMostOpen = 256;
    constexpr std::uint64_t kBeside = std::uint64_t{256} << 20;  // stacks of threads, and what malloc reserves for them
    bool isLimited = limit(RLIMIT_CORE, 0) && (kIsSanitized || limit(RLIMIT_FSIZE, 0)) && limit(RLIMIT_CPU, kMostCpuSeconds) &&
                     limit(RLIMIT_NOFILE, kMostOpen);
    if (memoryBytes == 0 || kIsSanitized) return isLimited;
    std::uint64_t pages = 0;
    if (!(std::ifstream("/proc/self/statm") >> pages)) return false;
    return limit(RLIMIT_AS, pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + memoryBytes + kBeside) && isLimited;
}

/// Lets no file be opened, and no port be bound or connected. Descriptors that are open stay usable.
bool raiseLandlock() {
    // The struct of later kernels than Debian 12's headers know; older ones take a part of it.
    struct Rights {
        std::uint64_t files = 0, network = 0, scopes = 0;
    };
    const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) return false;
    Rights rights;
    const int fileRights = version >= 5 ? 16 : version >= 3 ? 15 : version >= 2 ? 14 : 13;
    rights.files = (std::uint64_t{1} << fileRights) - 1;
    if (version >= 4) rights.network = 3;  // bind and connect
    if (version >= 6) rights.scopes = 3;   // abstract sockets and signals
    const std::size_t bytes = version >= 6 ? sizeof rights : version >= 4 ? 2 * sizeof rights.files : sizeof rights.files;
    const long rules = ::syscall(SYS_landlock_create_ruleset, &rights, bytes, 0);
    if (rules < 0) return false;
    const bool isRaised = ::syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    ::close(static_cast<int>(rules));
    return isRaised;
}

/// System calls that a reader makes. Those below look at an argument.
constexpr int kAllowedCalls[] = {
    SYS_read,
    SYS_readv,
    SYS_pread64,
    SYS_preadv,
    SYS_write,
    SYS_writev,
    SYS_lseek,
    SYS_close,
    SYS_dup,
    SYS_fadvise64,
    SYS_recvmsg,
    SYS_sendmsg,
    SYS_ppoll,
    SYS_pselect6,  // of descriptors that are open
    SYS_brk,
    SYS_munmap,
    SYS_mremap,
    SYS_madvise,
    SYS_mincore,
    SYS_membarrier,  // memory
    SYS_futex,
    SYS_set_robust_list,
    SYS_get_robust_list,
    SYS_set_tid_address,
    SYS_rseq,  // threads
    SYS_sched_yield,
    SYS_sched_getaffinity,
    SYS_sched_getparam,
    SYS_sched_getscheduler,
    SYS_gettid,
    SYS_getpid,
    SYS_getppid,
    SYS_exit,
    SYS_exit_group,
    SYS_clock_gettime,
    SYS_clock_getres,
    SYS_clock_nanosleep,
    SYS_nanosleep,
    SYS_gettimeofday,
    SYS_times,
    SYS_getrusage,
    SYS_rt_sigaction,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_sigaltstack,
    SYS_restart_syscall,
    SYS_getrandom,
    SYS_uname,
    SYS_sysinfo,
    SYS_getuid,
    SYS_geteuid,
    SYS_getgid,
    SYS_getegid,
    SYS_getcwd,
#ifdef __x86_64__
    SYS_poll,
    SYS_select,
    SYS_time,
    SYS_fstat,
#else
    SYS_fstat,
#endif
};

constexpr std::uint32_t kArgument0 = offsetof(seccomp_data, args);  // the lower half of one: both machines are little-endian
constexpr std::uint32_t kArgumentBytes = sizeof(__u64);

/// A filter for system calls (BPF), put together call by call.
class CallFilter {
public:
    CallFilter() {
#ifdef __x86_64__
        constexpr std::uint32_t kMachine = AUDIT_ARCH_X86_64;
#else
        constexpr std::uint32_t kMachine = AUDIT_ARCH_AARCH64;
#endif
        load(offsetof(seccomp_data, arch));
        program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kMachine, 1, 0));
        end(SECCOMP_RET_KILL_PROCESS);
        load(offsetof(seccomp_data, nr));
        // The calls of x32 have numbers of their own: they are in no row, and so refused.
    }
    void allow(int call) {
        jumpUnless(static_cast<std::uint32_t>(call), 1);
        end(SECCOMP_RET_ALLOW);
    }
    void answer(int call, int errorNumber) {
        jumpUnless(static_cast<std::uint32_t>(call), 1);
        end(SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(errorNumber));
    }
    /// Allows a call if an argument, of which only the bits of `mask` count, is `value`.
    void allowIf(int call, std::uint32_t argument, std::uint32_t mask, std::uint32_t value) {
        jumpUnless(static_cast<std::uint32_t>(call), 5);
        load(kArgument0 + argument * kArgumentBytes);
        program_.push_back(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, mask));
        jumpUnless(value, 1);
        end(SECCOMP_RET_ALLOW);
        load(offsetof(seccomp_data, nr));  // of which a later row may allow another value
    }
    bool install() {
        end(SECCOMP_RET_ERRNO | EPERM);
        const sock_fprog program{static_cast<unsigned short>(program_.size()), program_.data()};
        return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
    }

private:
    void load(std::uint32_t offset) {
        program_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offset));
    }
    void end(std::uint32_t verdict) {
        program_.push_back(BPF_STMT(BPF_RET | BPF_K, verdict));
    }
    /// Jumps over `count` instructions unless what was loaded is equal.
    void jumpUnless(std::uint32_t value, std::uint8_t count) {
        program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, count));
    }
    std::vector<sock_filter> program_;
};

bool raiseSeccomp() {
    constexpr auto kWhole = ~std::uint32_t{0};
    const auto self = static_cast<std::uint32_t>(::getpid());
    CallFilter filter;
    for (const int call : kAllowedCalls) filter.allow(call);
    // No memory becomes executable, and of processes only threads are made.
    filter.allowIf(SYS_mmap, 2, PROT_EXEC, 0);
    filter.allowIf(SYS_mprotect, 2, PROT_EXEC, 0);
    constexpr std::uint32_t kThread = CLONE_VM | CLONE_THREAD | CLONE_SIGHAND;
    filter.allowIf(SYS_clone, 0, kThread, kThread);
    filter.answer(SYS_clone3, ENOSYS);  // its flags lie in memory: the C library takes clone() instead
    // These calls act on descriptors that are open. Other commands of fcntl() let the kernel send signals.
    constexpr std::uint32_t kEmptyPath = 0x1000;  // AT_EMPTY_PATH
    filter.allowIf(SYS_newfstatat, 3, kEmptyPath, kEmptyPath);
    filter.allowIf(SYS_statx, 2, kEmptyPath, kEmptyPath);
    for (const std::uint32_t command : {F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_DUPFD_CLOEXEC}) filter.allowIf(SYS_fcntl, 1, kWhole, command);
    filter.answer(SYS_ioctl, ENOTTY);  // isatty()
    // The process may ask for its own limits, and end itself by abort().
    filter.allowIf(SYS_prlimit64, 0, kWhole, 0);
    filter.allowIf(SYS_tgkill, 0, kWhole, self);
    return filter.install();
}

}  // namespace

Walls putUpWalls(std::uint64_t memoryBytes) {
    Walls walls = 0;
    if (limitResources(memoryBytes)) walls |= kLimitsWall;
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) == 0) walls |= kPrivilegesWall;
    if (kIsSanitized) return walls;
    if (raiseLandlock()) walls |= kLandlockWall;
    if (raiseSeccomp()) walls |= kSeccompWall;
    return walls;
}

bool areReadersSanitized() {
    return kIsSanitized;
}

std::vector<std::string> namesOfWalls(Walls walls) {
    constexpr std::string_view kNames[] = {"limits", "privileges", "landlock", "seccomp"};
    std::vector<std::string> names;
    for (std::size_t bit = 0; bit < std::size(kNames); ++bit)
        if ((walls & Walls{1} << bit) != 0) names.emplace_back(kNames[bit]);
    return names;
}

}  // namespace lightcook::formats
