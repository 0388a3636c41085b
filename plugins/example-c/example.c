/* A payload plugin in C: counts how often it was called, can be set back, reports the count.
 *
 * Nothing but the header and the C library. What crosses as bytes is CBOR; the little of it that is needed stands below.
 *
 * Must never do: trust a length that came in, return memory that is not its own, let a call take long. */

#include "skein_plugin.h"

#include <stdio.h>
#include <string.h>

#define CREATE_SCHEMA 1
#define EVENT_BATCH_SCHEMA 1
#define EFFECT_BATCH_SCHEMA 1

/* Codes of events and effects, as skein_domain::exchange numbers them. */
enum { EVENT_TICK = 0, EVENT_PAYLOAD_COMMAND = 11 };
enum { EFFECT_COMMAND_PROGRESS = 3, EFFECT_REPORT = 11 };
enum { PROGRESS_DONE = 1 };

/* ---- writing CBOR: into memory that grows; once there is none, nothing more is written and the answer is empty */

typedef struct {
  uint8_t *data;
  size_t len, capacity;
  bool failed;
} Writer;

static void put(Writer *w, const void *bytes, size_t len) {
  if (!w->failed && w->len + len > w->capacity) {
    size_t capacity = (w->len + len) * 2;
    uint8_t *data = realloc(w->data, capacity);
    if (data) {
      w->data = data;
      w->capacity = capacity;
    } else {
      w->failed = true;
    }
  }
  if (!w->failed) {
    memcpy(w->data + w->len, bytes, len);
    w->len += len;
  }
}

/* The head of an item: what it is (0 number, 2 bytes, 3 text, 4 list) and its value or length. */
static void put_head(Writer *w, uint8_t major, uint64_t value) {
  uint8_t bytes[9];
  size_t following = value < 24 ? 0 : value <= 0xff ? 1 : value <= 0xffff ? 2 : value <= 0xffffffff ? 4 : 8;
  uint8_t low = following == 0 ? (uint8_t)value : following == 1 ? 24 : following == 2 ? 25 : following == 4 ? 26 : 27;
  bytes[0] = (uint8_t)(major << 5 | low);
  for (size_t i = 0; i < following; i++)
    bytes[1 + i] = (uint8_t)(value >> (8 * (following - 1 - i)));
  put(w, bytes, 1 + following);
}

static void put_number(Writer *w, uint64_t value) { put_head(w, 0, value); }
static void put_list(Writer *w, uint64_t items) { put_head(w, 4, items); }
static void put_null(Writer *w) { put(w, "\xf6", 1); }
static void put_text(Writer *w, const char *text) {
  put_head(w, 3, strlen(text));
  put(w, text, strlen(text));
}

static SkeinBuffer finished(Writer *w) {
  if (w->failed) {
    free(w->data);
    return (SkeinBuffer){NULL, 0, 0};
  }
  return (SkeinBuffer){w->data, w->len, w->capacity};
}

/* ---- reading CBOR: past the end everything fails */

typedef struct {
  const uint8_t *at, *end;
  bool failed;
} Reader;

static uint64_t take_head(Reader *r, uint8_t *major) {
  *major = 0xff;
  if (r->failed || r->at == r->end) {
    r->failed = true;
    return 0;
  }
  uint8_t first = *r->at++, low = first & 0x1f;
  if (low < 24) {
    *major = first >> 5;
    return low;
  }
  size_t following = low == 24 ? 1 : low == 25 ? 2 : low == 26 ? 4 : low == 27 ? 8 : 0;
  if (following == 0 || (size_t)(r->end - r->at) < following) {
    r->failed = true; /* Lists without a length do not come. */
    return 0;
  }
  uint64_t value = 0;
  while (following--)
    value = value << 8 | *r->at++;
  *major = first >> 5;
  return value;
}

static uint64_t take(Reader *r, uint8_t expected) {
  uint8_t major;
  uint64_t value = take_head(r, &major);
  if (major != expected)
    r->failed = true;
  return r->failed ? 0 : value;
}

/* The bytes of a text or of bytes; NULL if it is something else. */
static const uint8_t *take_bytes(Reader *r, uint8_t expected, size_t *len) {
  uint64_t value = take(r, expected);
  if (r->failed || (uint64_t)(r->end - r->at) < value) {
    r->failed = true;
    *len = 0;
    return NULL;
  }
  const uint8_t *bytes = r->at;
  *len = (size_t)value;
  r->at += value;
  return bytes;
}

/* Over one item, whatever it is. `left` counts the items still to be passed, so that nothing nests on the stack. */
static void skip(Reader *r) {
  for (uint64_t left = 1; left > 0 && !r->failed; left--) {
    uint8_t major;
    uint64_t value = take_head(r, &major);
    if (major == 2 || major == 3) {
      if ((uint64_t)(r->end - r->at) < value)
        r->failed = true;
      else
        r->at += value;
    } else if (major == 4 || major == 5) {
      if (value > (uint64_t)(r->end - r->at)) /* Each item has a byte at least. */
        r->failed = true;
      else
        left += major == 5 ? 2 * value : value;
    } else if (major == 6) {
      left++;
    }
  }
}

/* ---- the plugin */

typedef struct {
  SkeinHostServices host;
  uint64_t ticks;
} Instance;

static SkeinOutcome answer(uint32_t schema, Writer *w) {
  return (SkeinOutcome){SKEIN_STATUS_OK, schema, finished(w)};
}

static SkeinOutcome failed(uint32_t status, const char *why) {
  Writer w = {0};
  put(&w, why, strlen(why));
  return (SkeinOutcome){status, 0, finished(&w)};
}

static SkeinOutcome manifest(void) {
  Writer w = {0};
  put_list(&w, 10);
  put_text(&w, "example-c");
  put_text(&w, "0.1.0");
  put_text(&w, "Counts how often it was called. A payload plugin in C.");
  put_text(&w, "{\"type\":\"object\",\"additionalProperties\":false}");
  put_list(&w, 2);
  put_number(&w, EFFECT_COMMAND_PROGRESS);
  put_number(&w, EFFECT_REPORT);
  put_text(&w, "{\"type\":\"object\",\"properties\":{\"command\":{\"const\":\"reset\"}},"
               "\"required\":[\"command\"],\"additionalProperties\":false}");
  put_text(&w, "{\"type\":\"object\",\"properties\":{\"ticks\":{\"type\":\"integer\"}},\"required\":[\"ticks\"]}");
  put_null(&w); /* tells no events */
  put_null(&w); /* wants no MAVLink */
  put_number(&w, 5);
  return answer(0, &w);
}

static SkeinCreateOutcome create(const SkeinHostServices *host, uint32_t schema, SkeinSlice bytes) {
  Instance *instance = schema == CREATE_SCHEMA ? calloc(1, sizeof(Instance)) : NULL;
  if (!instance) {
    SkeinOutcome why = failed(SKEIN_STATUS_UNKNOWN_SCHEMA, "not the schema of this plugin, or no memory");
    return (SkeinCreateOutcome){why.status, 0, NULL, why.buffer};
  }
  instance->host = *host;
  /* vehicle, incarnation, configuration, snapshot, ... */
  Reader r = {bytes.data, bytes.data + bytes.len, false};
  uint64_t fields = take(&r, 4);
  for (int i = 0; i < 3 && fields > 3; i++)
    skip(&r);
  size_t len = 0;
  const uint8_t *snapshot = fields > 3 ? take_bytes(&r, 2, &len) : NULL;
  /* One that it does not understand does not keep it from starting. */
  if (snapshot && len == sizeof instance->ticks)
    memcpy(&instance->ticks, snapshot, len);
  static const char text[] = "counting";
  host->log(host->context, SKEIN_LOG_INFO, (SkeinSlice){(const uint8_t *)text, sizeof text - 1});
  return (SkeinCreateOutcome){SKEIN_STATUS_OK, 0, instance, {NULL, 0, 0}};
}

static SkeinOutcome handle_events(Instance *instance, SkeinSlice bytes) {
  Reader r = {bytes.data, bytes.data + bytes.len, false};
  Writer effects = {0};
  uint64_t count = 0;
  take(&r, 4); /* the batch: now, events */
  skip(&r);
  for (uint64_t events = take(&r, 4); events > 0 && !r.failed; events--) {
    take(&r, 4); /* an event: its code, its fields */
    uint64_t code = take(&r, 0);
    if (code == EVENT_TICK) {
      instance->ticks++;
      skip(&r);
    } else if (code == EVENT_PAYLOAD_COMMAND) {
      uint64_t fields = take(&r, 4), id = take(&r, 0);
      for (; fields > 1; fields--)
        skip(&r); /* There is one command, and the host has checked it against the schema. */
      instance->ticks = 0;
      put_list(&effects, 2);
      put_number(&effects, EFFECT_COMMAND_PROGRESS);
      put_list(&effects, 2);
      put_number(&effects, id);
      put_list(&effects, 2);
      put_number(&effects, PROGRESS_DONE);
      put_list(&effects, 0);
      count++;
    } else {
      skip(&r); /* An event that this plugin does not know, perhaps of a newer host. */
    }
  }
  if (r.failed) {
    free(effects.data);
    return failed(SKEIN_STATUS_UNDECODABLE, "the events cannot be read");
  }
  char state[64];
  snprintf(state, sizeof state, "{\"ticks\":%llu}", (unsigned long long)instance->ticks);
  Writer w = {0};
  put_list(&w, 1); /* the batch: effects */
  put_list(&w, count + 1);
  if (effects.failed)
    w.failed = true;
  else
    put(&w, effects.data ? (const void *)effects.data : "", effects.len);
  put_list(&w, 2);
  put_number(&w, EFFECT_REPORT);
  put_list(&w, 1);
  put_text(&w, state);
  free(effects.data);
  return answer(EFFECT_BATCH_SCHEMA, &w);
}

static SkeinOutcome invoke(SkeinPluginHandle handle, uint32_t method, uint32_t schema, SkeinSlice bytes) {
  Instance *instance = handle;
  if (method == SKEIN_METHOD_SNAPSHOT) {
    Writer w = {0};
    put(&w, &instance->ticks, sizeof instance->ticks);
    return answer(0, &w);
  }
  if (method != SKEIN_METHOD_HANDLE_EVENTS)
    return failed(SKEIN_STATUS_UNKNOWN_METHOD, "");
  if (schema != EVENT_BATCH_SCHEMA)
    return failed(SKEIN_STATUS_UNKNOWN_SCHEMA, "");
  return handle_events(instance, bytes);
}

static SkeinOutcome destroy(SkeinPluginHandle handle) {
  free(handle);
  return (SkeinOutcome){SKEIN_STATUS_OK, 0, {NULL, 0, 0}};
}

static void give_back(SkeinBuffer buffer) { free(buffer.data); }

static const SkeinPluginTable TABLE = {manifest, create, invoke, destroy, give_back};

#if defined(__x86_64__)
#define TARGET "x86_64-linux"
#elif defined(__aarch64__)
#define TARGET "aarch64-linux"
#endif

/* What the host looks for. It reads this in the file, before any code here runs. */
const SkeinHandshake SKEIN_PLUGIN = {
    .magic = {'S', 'K', 'E', 'I', 'N', 'P', 'L', 'G'},
    .abi_version = SKEIN_ABI_VERSION,
    .handshake_size = sizeof(SkeinHandshake),
    .table_size = sizeof(SkeinPluginTable),
    .kind = SKEIN_KIND_DETECTOR,
    .pointer_bits = 8 * sizeof(void *),
    .endianness = SKEIN_ENDIAN_LITTLE,
    .panic_strategy = SKEIN_PANIC_UNWIND,
    .target = TARGET,
    .table = &TABLE,
};
