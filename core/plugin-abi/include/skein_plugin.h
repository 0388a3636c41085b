/* The binary interface of Skein's plugins, made from the source of core/plugin-abi by its tests. ABI.md tells its rules.
 *
 * A plugin is a shared library that exports one constant, SKEIN_PLUGIN, a SkeinHandshake. What crosses as bytes is CBOR. */

#ifndef SKEIN_PLUGIN_H
#define SKEIN_PLUGIN_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* SkeinHandshake.abi_version */
#define SKEIN_ABI_VERSION 2
/* SkeinHandshake.magic, without the zero at the end */
#define SKEIN_MAGIC "SKEINPLG"
/* the name of the exported constant */
#define SKEIN_ENTRY_SYMBOL "SKEIN_PLUGIN"
/* bytes of SkeinHandshake.target */
#define SKEIN_TARGET_LEN 32
/* SkeinHandshake.endianness */
#define SKEIN_ENDIAN_LITTLE 1
/* SkeinHandshake.endianness */
#define SKEIN_ENDIAN_BIG 2
/* SkeinHandshake.panic_strategy: what a library in C says too, since nothing in it panics */
#define SKEIN_PANIC_UNWIND 1
/* SkeinHandshake.panic_strategy: no host takes it */
#define SKEIN_PANIC_ABORT 2
/* SkeinHandshake.kind */
#define SKEIN_KIND_UAV_MODEL 1
/* SkeinHandshake.kind */
#define SKEIN_KIND_GIMBAL 2
/* SkeinHandshake.kind */
#define SKEIN_KIND_CAMERA 3
/* SkeinHandshake.kind */
#define SKEIN_KIND_RADIO 4
/* SkeinHandshake.kind */
#define SKEIN_KIND_DETECTOR 5
/* SkeinOutcome.status */
#define SKEIN_STATUS_OK 0
/* SkeinOutcome.status */
#define SKEIN_STATUS_PANICKED 1
/* SkeinOutcome.status */
#define SKEIN_STATUS_REFUSED 2
/* SkeinOutcome.status */
#define SKEIN_STATUS_UNKNOWN_METHOD 3
/* SkeinOutcome.status */
#define SKEIN_STATUS_UNKNOWN_SCHEMA 4
/* SkeinOutcome.status */
#define SKEIN_STATUS_UNDECODABLE 5
/* SkeinOutcome.status */
#define SKEIN_STATUS_POISONED 6
/* level of a log line */
#define SKEIN_LOG_ERROR 1
/* level of a log line */
#define SKEIN_LOG_WARN 2
/* level of a log line */
#define SKEIN_LOG_INFO 3
/* level of a log line */
#define SKEIN_LOG_DEBUG 4
/* level of a log line */
#define SKEIN_LOG_TRACE 5
/* method of invoke */
#define SKEIN_METHOD_SNAPSHOT 1
/* method of invoke */
#define SKEIN_METHOD_HANDLE_EVENTS 2

/**
 * Bytes owned by the plugin that made them; they go back to it through `PluginTable::free`.
 */
typedef struct SkeinBuffer {
  /**
   * First byte; null for an empty buffer that needs no freeing.
   */
  uint8_t *data;
  /**
   * Number of bytes in use.
   */
  size_t len;
  /**
   * Number of bytes allocated; only its maker makes sense of it.
   */
  size_t capacity;
} SkeinBuffer;

/**
 * How a call ended, with its answer.
 */
typedef struct SkeinOutcome {
  /**
   * A `Status`.
   */
  uint32_t status;
  /**
   * Schema of the bytes in `buffer`, 0 for text.
   */
  uint32_t schema;
  /**
   * The answer; its owner is the plugin.
   */
  struct SkeinBuffer buffer;
} SkeinOutcome;

/**
 * Gives the manifest (`skein_domain::manifest::PluginManifest`) as CBOR.
 */
typedef struct SkeinOutcome (*SkeinManifestFn)(void);

/**
 * An instance, as the plugin that made it knows it. The host only keeps it and gives it back.
 */
typedef void *SkeinPluginHandle;

/**
 * How the creation of an instance ended.
 */
typedef struct SkeinCreateOutcome {
  /**
   * A `Status`.
   */
  uint32_t status;
  /**
   * Zero.
   */
  uint32_t reserved;
  /**
   * The instance; null unless the status is `Status::OK`.
   */
  SkeinPluginHandle handle;
  /**
   * The reason as text unless the status is `Status::OK`; its owner is the plugin.
   */
  struct SkeinBuffer buffer;
} SkeinCreateOutcome;

/**
 * Borrowed bytes, valid for the time of one call.
 */
typedef struct SkeinSlice {
  /**
   * First byte; may be null when `len` is 0.
   */
  const uint8_t *data;
  /**
   * Number of bytes.
   */
  size_t len;
} SkeinSlice;

/**
 * A frame buffer that the host lends to an instance to write a frame into.
 */
typedef struct SkeinFrameBuffer {
  /**
   * Names it in what is said of the frame later; 0 if there was none to lend.
   */
  uint64_t id;
  /**
   * First byte; null if there was none to lend.
   */
  uint8_t *data;
  /**
   * Number of bytes, at least as many as were asked for.
   */
  size_t len;
} SkeinFrameBuffer;

/**
 * What the host does for an instance. Given to `create`, so that it is there before any code of the instance runs. The struct is
 * borrowed for the call; what it holds is valid until `create` has failed or `destroy` has returned, from any thread.
 *
 * Frames never cross as copies: a camera asks for a buffer, writes into it and names it in an effect, from when on it is the host's;
 * whoever gets an event about the frame reads the same bytes.
 */
typedef struct SkeinHostServices {
  /**
   * Size of this struct in bytes.
   */
  size_t size;
  /**
   * The host's; given back in every call.
   */
  void *context;
  /**
   * Takes one log line: context, a `LogLevel`, UTF-8 text.
   */
  void (*log)(void *context, uint32_t level, struct SkeinSlice text);
  /**
   * Lends a buffer of at least `len` bytes. None is lent while all of the instance's are in use: the frame is to be dropped then.
   */
  struct SkeinFrameBuffer (*acquire_frame)(void *context, size_t len);
  /**
   * Takes back a lent buffer that was not named in an effect.
   */
  void (*release_frame)(void *context, uint64_t id);
  /**
   * The bytes of a frame that an event of the call being made names; empty for any other. Only during that call.
   */
  struct SkeinSlice (*read_frame)(void *context, uint64_t id);
} SkeinHostServices;

/**
 * Makes an instance: what the host does for it, schema of the bytes, the bytes (what they are depends on the kind of plugin).
 */
typedef struct SkeinCreateOutcome (*SkeinCreateFn)(const struct SkeinHostServices *host,
                                                   uint32_t schema,
                                                   struct SkeinSlice bytes);

/**
 * Calls a method of an instance: a number from `method`, schema of the bytes, the bytes.
 */
typedef struct SkeinOutcome (*SkeinInvokeFn)(SkeinPluginHandle handle,
                                             uint32_t method,
                                             uint32_t schema,
                                             struct SkeinSlice bytes);

/**
 * Ends an instance; the handle is not used again.
 */
typedef struct SkeinOutcome (*SkeinDestroyFn)(SkeinPluginHandle handle);

/**
 * Takes back a buffer of this plugin, from any thread.
 */
typedef void (*SkeinFreeFn)(struct SkeinBuffer buffer);

/**
 * The entry points of a plugin. Never grows: new things come as new methods of `invoke`. Each may be null in a library that was
 * not made with the SDK, so the host looks before it calls (`PluginTable::complete`).
 */
typedef struct SkeinPluginTable {
  /**
   * See `ManifestFn`.
   */
  SkeinManifestFn manifest;
  /**
   * See `CreateFn`.
   */
  SkeinCreateFn create;
  /**
   * See `InvokeFn`.
   */
  SkeinInvokeFn invoke;
  /**
   * See `DestroyFn`.
   */
  SkeinDestroyFn destroy;
  /**
   * See `FreeFn`.
   */
  SkeinFreeFn free;
} SkeinPluginTable;

/**
 * What a library says of itself. The first three fields are the same in every version for ever.
 */
typedef struct SkeinHandshake {
  /**
   * `MAGIC`.
   */
  uint8_t magic[8];
  /**
   * `ABI_VERSION` the plugin was built with.
   */
  uint32_t abi_version;
  /**
   * Size of this struct in bytes, as the plugin has it.
   */
  uint32_t handshake_size;
  /**
   * Size of `PluginTable` in bytes, as the plugin has it.
   */
  uint32_t table_size;
  /**
   * What the plugin is for: a `PluginKind`.
   */
  uint32_t kind;
  /**
   * Bits of a pointer.
   */
  uint8_t pointer_bits;
  /**
   * `ENDIAN_LITTLE` or `ENDIAN_BIG`.
   */
  uint8_t endianness;
  /**
   * `PANIC_UNWIND` or `PANIC_ABORT`.
   */
  uint8_t panic_strategy;
  /**
   * Zero.
   */
  uint8_t reserved[5];
  /**
   * Architecture and operating system in words, for people: `x86_64-linux`, filled up with zeros.
   */
  uint8_t target[SKEIN_TARGET_LEN];
  /**
   * The entry points. Not to be followed before everything above was found right.
   */
  const struct SkeinPluginTable *table;
} SkeinHandshake;

#endif  /* SKEIN_PLUGIN_H */
