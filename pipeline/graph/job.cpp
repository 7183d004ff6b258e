#include "pipeline/graph/job.h"

#include <fmt/format.h>

#include "pipeline/graph/record_fields.h"
#include "pipeline/graph/version.h"
#include "pipeline/source_digest.h"

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::Result;

template <class Fields, Is<ProgramIdentity> Self>
void describe(Fields& fields, Self& program) {
    fields.required("version", program.version, "of lightcook");
    fields.required("sources", program.sources, "digest of its sources");
    fields.required("compiler", program.compiler, "that built it");
}
template <class Fields, Is<SharedContent> Self>
void describe(Fields& fields, Self& content) {
    fields.required("name", content.name, "path");
    fields.required("sha256", content.sha256, "SHA-256; empty where the machines share the cache folder");
    fields.required("digest", content.digest, "XXH3-128");
    fields.required("bytes", content.bytes, "size");
}
template <class Fields, Is<JobInput> Self>
void describe(Fields& fields, Self& input) {
    fields.required("role", input.role, "role");
    fields.required("absolute", input.absolute, "absolute path");
    fields.required("content", input.content, "content");
}
template <class Fields, Is<Action> Self>
void describe(Fields& fields, Self& action) {
    fields.required("id", action.id, "name in the graph");
    fields.required("kind", action.kind, "function");
    fields.required("asset", action.asset, "asset");
    fields.required("parameters", action.parameters, "parameters");
    fields.required("dependencies", action.dependencies, "ids of other actions");
}
template <class Fields, Is<Job> Self>
void describe(Fields& fields, Self& job) {
    fields.required("program", job.program, "program that wrote the job");
    fields.required("key", job.key, "digest of the action");
    fields.required("force", job.force, "run whatever the cache has");
    fields.required("action", job.action, "action");
    fields.required("inputs", job.inputs, "inputs");
    fields.required("upstream", job.upstream, "records of the dependencies");
    fields.required("files", job.files, "files of the dependencies");
}

namespace {

std::string wordsOf(const ProgramIdentity& program) {
    return fmt::format("{} {} (sources {}, compiler {})", kToolName, program.version, program.sources.substr(0, 12), program.compiler);
}

}  // namespace

ProgramIdentity thisProgram() {
    return {kToolVersion, kSourceDigest, __VERSION__};
}

std::string textOfJob(const Job& job) {
    return toJson(job).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<Job> readJob(const std::string& text, const std::string& machine) {
    const Json json = parseJson(text);
    const Json program = json.is_object() ? json.value("program", Json()) : Json();
    LC_TRY(wanted, fromJson<ProgramIdentity>(program, "job"));
    if (*wanted != thisProgram())
        return formats::failure(ErrorCode::InvalidRequest, machine,
                                fmt::format("found {}, expected {}, which launched the action: install the same on every machine",
                                            wordsOf(thisProgram()), wordsOf(*wanted)));
    return fromJson<Job>(json, "job");
}

}  // namespace lightcook::pipeline
