// Records of actions as JSON.
#pragma once

#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

template <class Fields, Is<FileRecord> Self>
void describe(Fields& fields, Self& file) {
    fields.required("name", file.name, kFileInFolder, "path, relative to the output folder");
    fields.required("digest", file.digest, "XXH3-128 of the content");
    fields.required("bytes", file.bytes, "size");
}
template <class Fields, Is<ActionRecord> Self>
void describe(Fields& fields, Self& record) {
    fields.required("id", record.id, "action");
    fields.required("seconds", record.seconds, "wall time of its last run");
    fields.presentIf(!record.run.empty(), "run", record.run, "run that made it");
    fields.presentIf(record.peakRssBytes > 0, "peak_rss_bytes", record.peakRssBytes, "memory of a process that ran it alone");
    fields.required("result", record.result, "result of the action");
    fields.required("files", record.files, "files that it wrote");
}

}  // namespace lightcook::pipeline
