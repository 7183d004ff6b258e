#include "bench/example_peers/mapped_program.h"

#include <dlfcn.h>
#include <elf.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>

namespace lightcook::bench {
namespace {

constexpr std::uint64_t kPage = 4096;

/// Returns the place of an address that the program was linked for.
void* placeOf(std::uint64_t address) {
    return reinterpret_cast<void*>(address);  // NOLINT(performance-no-int-to-ptr)
}

std::string read(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw std::runtime_error(file + ": cannot be opened");
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Returns a table of the file. Throws if the file ends before.
template <class Entry>
std::span<const Entry> table(const std::string& bytes, std::uint64_t offset, std::uint64_t count) {
    if (offset > bytes.size() || count > (bytes.size() - offset) / sizeof(Entry)) throw std::runtime_error("the file is truncated");
    return {reinterpret_cast<const Entry*>(bytes.data() + offset), count};
}

std::span<const Elf64_Shdr> sectionsOf(const std::string& bytes) {
    const Elf64_Ehdr& head = table<Elf64_Ehdr>(bytes, 0, 1)[0];
    return table<Elf64_Shdr>(bytes, head.e_shoff, head.e_shnum);
}

/// A table of symbols and the section of their names.
struct Symbols {
    std::span<const Elf64_Sym> entries;
    std::span<const char> names;

    [[nodiscard]] const char* name(const Elf64_Sym& symbol) const { return names.subspan(symbol.st_name).data(); }
};
Symbols symbolsOf(const std::string& bytes, const Elf64_Shdr& section) {
    const Elf64_Shdr& names = sectionsOf(bytes)[section.sh_link];
    return {table<Elf64_Sym>(bytes, section.sh_offset, section.sh_size / sizeof(Elf64_Sym)),
            table<char>(bytes, names.sh_offset, names.sh_size)};
}

/// Copies a segment to the addresses that it was linked for, with its rights.
void mapSegment(const std::string& bytes, const Elf64_Phdr& segment) {
    const std::uint64_t begin = segment.p_vaddr / kPage * kPage, size = segment.p_vaddr + segment.p_memsz - begin;
    void* const wanted = placeOf(begin);
    if (mmap(wanted, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0) != wanted)
        throw std::runtime_error("its addresses are taken in this process");
    const auto content = table<char>(bytes, segment.p_offset, segment.p_filesz);
    std::copy(content.begin(), content.end(), static_cast<char*>(placeOf(segment.p_vaddr)));
    if ((segment.p_flags & PF_X) != 0 && mprotect(wanted, size, PROT_READ | PROT_EXEC) != 0)
        throw std::runtime_error("its code cannot be made executable");
}

/// Loads the libraries that the program names, so that dlsym() finds their symbols.
void loadLibraries(const std::string& bytes, const Elf64_Shdr& dynamic) {
    const Elf64_Shdr& names = sectionsOf(bytes)[dynamic.sh_link];
    for (const Elf64_Dyn& entry : table<Elf64_Dyn>(bytes, dynamic.sh_offset, dynamic.sh_size / sizeof(Elf64_Dyn))) {
        if (entry.d_tag != DT_NEEDED) continue;
        if (!dlopen(bytes.data() + names.sh_offset + entry.d_un.d_val, RTLD_NOW | RTLD_GLOBAL)) throw std::runtime_error(dlerror());
    }
}

/// Connects the program with the functions and objects of its libraries.
void relocate(const std::string& bytes, const Elf64_Shdr& section) {
    const Symbols symbols = symbolsOf(bytes, sectionsOf(bytes)[section.sh_link]);
    for (const Elf64_Rela& entry : table<Elf64_Rela>(bytes, section.sh_offset, section.sh_size / sizeof(Elf64_Rela))) {
        const Elf64_Sym& symbol = symbols.entries[ELF64_R_SYM(entry.r_info)];
        const void* const found = dlsym(RTLD_DEFAULT, symbols.name(symbol));
        const bool isOptional = ELF64_ST_BIND(symbol.st_info) == STB_WEAK && ELF64_R_TYPE(entry.r_info) != R_X86_64_COPY;
        if (!found && !isOptional) throw std::runtime_error(std::string("no library has ") + symbols.name(symbol));
        void* const place = placeOf(entry.r_offset);
        switch (ELF64_R_TYPE(entry.r_info)) {
            case R_X86_64_GLOB_DAT:
            case R_X86_64_JUMP_SLOT:
                std::memcpy(place, &found, sizeof(found));
                break;
            case R_X86_64_COPY:
                std::memcpy(place, found, symbol.st_size);
                break;
            default:
                throw std::runtime_error("it has relocations of an unknown type");
        }
    }
}

void load(const std::string& bytes) {
    const Elf64_Ehdr& head = table<Elf64_Ehdr>(bytes, 0, 1)[0];
    if (std::memcmp(head.e_ident, ELFMAG, SELFMAG) != 0 || head.e_machine != EM_X86_64 || head.e_type != ET_EXEC)
        throw std::runtime_error("it is no program of x86-64 Linux with fixed addresses");
    for (const Elf64_Phdr& segment : table<Elf64_Phdr>(bytes, head.e_phoff, head.e_phnum))
        if (segment.p_type == PT_LOAD) mapSegment(bytes, segment);
    for (const Elf64_Shdr& section : sectionsOf(bytes))
        if (section.sh_type == SHT_DYNAMIC) loadLibraries(bytes, section);
    for (const Elf64_Shdr& section : sectionsOf(bytes))
        if (section.sh_type == SHT_RELA) relocate(bytes, section);
}

}  // namespace

MappedProgram::MappedProgram(const std::string& file) : file_(file), bytes_(read(file)) {
    try {
        load(bytes_);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(file + ": " + error.what());
    }
}

void* MappedProgram::addressOf(const std::string& symbol) const {
    for (const Elf64_Shdr& section : sectionsOf(bytes_)) {
        if (section.sh_type != SHT_SYMTAB) continue;
        const Symbols symbols = symbolsOf(bytes_, section);
        for (const Elf64_Sym& each : symbols.entries)
            if (symbol == symbols.name(each) && each.st_value != 0) return placeOf(each.st_value);
    }
    throw std::runtime_error(file_ + ": has no function " + symbol);
}

}  // namespace lightcook::bench
