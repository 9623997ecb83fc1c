// What a WASI command needs of its system: three streams, a clock, and files in memory below `/`.
// No threads, no network, no chance.

const OK = 0, BAD_FILE = 8, EXISTS = 20, NO_FILE = 44, NO_SUCH_CALL = 52, NO_DIRECTORY = 54;
const CREATE = 1, DIRECTORY = 2, EXCLUSIVE = 4, TRUNCATE = 8;
const IS_STREAM = 2, IS_DIRECTORY = 3, IS_FILE = 4;
const ROOT = 3;
const ALL_RIGHTS = 0x1fffffffn;

/** The end that a command asks for. */
class Exit extends Error {
  constructor(code) {
    super(`the command ended with ${code}`);
    this.code = code;
  }
}

/** Bytes of a file, with room to grow. */
class Content {
  constructor(bytes) {
    this.room = bytes;
    this.length = bytes.length;
  }

  bytes() {
    return this.room.subarray(0, this.length);
  }

  write(at, bytes) {
    const end = at + bytes.length;
    if (end > this.room.length) {
      const room = new Uint8Array(Math.max(end, 2 * this.room.length));
      room.set(this.bytes());
      this.room = room;
    }
    this.room.set(bytes, at);
    this.length = Math.max(this.length, end);
  }
}

/** Lines of a stream, each of which is given away as soon as it is whole. */
class Lines {
  constructor(take) {
    this.take = take;
    this.begun = [];
  }

  write(bytes) {
    for (;;) {
      const end = bytes.indexOf(10);
      if (end < 0) break;
      this.begun.push(bytes.slice(0, end));
      const line = new Uint8Array(this.begun.reduce((sum, part) => sum + part.length, 0));
      let at = 0;
      for (const part of this.begun) {
        line.set(part, at);
        at += part.length;
      }
      this.begun = [];
      this.take(new TextDecoder().decode(line));
      bytes = bytes.subarray(end + 1);
    }
    if (bytes.length > 0) this.begun.push(bytes.slice());
  }
}

/**
 * Runs a command to its end, and returns its exit status.
 *
 * `files` maps plain names to bytes; what the command writes is there afterwards. `onLine` takes
 * each line of standard output. A panic is thrown as an error with what the command said of it.
 */
export function run(module, { args, stdin, files, onLine }) {
  const encoded = (text) => new TextEncoder().encode(text);
  const words = args.map((word) => encoded(`${word}\0`));
  const said = [];
  const streams = [
    { content: new Content(stdin), at: 0 },
    { lines: new Lines(onLine) },
    { lines: new Lines((line) => said.push(line)) },
    { isRoot: true },
  ];
  const open = new Map(streams.map((stream, fd) => [fd, stream]));
  let next = streams.length;
  let instance;
  const view = () => new DataView(instance.exports.memory.buffer);
  const memory = (at, length) => new Uint8Array(instance.exports.memory.buffer, at, length);
  const name = (at, length) =>
    new TextDecoder().decode(memory(at, length)).replace(/^(\.?\/)+/, "").replace(/^\.$/, "");
  const kind = (file) => (file.isRoot ? IS_DIRECTORY : file.lines ? IS_STREAM : IS_FILE);
  const setStatus = (at, type, size) => {
    memory(at, 64).fill(0);
    view().setUint8(at + 16, type);
    view().setBigUint64(at + 24, 1n, true);
    view().setBigUint64(at + 32, BigInt(size), true);
  };
  const each = (list, count, use) => {
    let sum = 0;
    for (let k = 0; k < count; k++) {
      const at = view().getUint32(list + 8 * k, true);
      sum += use(memory(at, view().getUint32(list + 8 * k + 4, true)));
    }
    return sum;
  };
  const setWords = (list, at) => {
    for (const word of words) {
      view().setUint32(list, at, true);
      memory(at, word.length).set(word);
      list += 4;
      at += word.length;
    }
    return OK;
  };
  const known = {
    args_sizes_get(count, size) {
      view().setUint32(count, words.length, true);
      view().setUint32(size, words.reduce((sum, word) => sum + word.length, 0), true);
      return OK;
    },
    args_get: setWords,
    environ_sizes_get(count, size) {
      view().setUint32(count, 0, true);
      view().setUint32(size, 0, true);
      return OK;
    },
    environ_get: () => OK,
    clock_time_get(clock, precision, at) {
      const ms = clock === 0 ? Date.now() : performance.now();
      view().setBigUint64(at, BigInt(Math.round(ms * 1e6)), true);
      return OK;
    },
    // seeds of hash tables, on which no answer depends
    random_get(at, length) {
      memory(at, length).fill(7);
      return OK;
    },
    sched_yield: () => OK,
    proc_exit(code) {
      throw new Exit(code);
    },
    fd_prestat_get(fd, at) {
      if (fd !== ROOT) return BAD_FILE;
      view().setUint32(at, 0, true);
      view().setUint32(at + 4, 1, true);
      return OK;
    },
    fd_prestat_dir_name(fd, at) {
      memory(at, 1)[0] = "/".charCodeAt(0);
      return OK;
    },
    fd_fdstat_get(fd, at) {
      const file = open.get(fd);
      if (!file) return BAD_FILE;
      memory(at, 24).fill(0);
      view().setUint8(at, kind(file));
      view().setBigUint64(at + 8, ALL_RIGHTS, true);
      view().setBigUint64(at + 16, ALL_RIGHTS, true);
      return OK;
    },
    fd_filestat_get(fd, at) {
      const file = open.get(fd);
      if (!file) return BAD_FILE;
      setStatus(at, kind(file), file.content?.length ?? 0);
      return OK;
    },
    fd_read(fd, list, count, at) {
      const file = open.get(fd);
      if (!file?.content) return BAD_FILE;
      const read = each(list, count, (room) => {
        const bytes = file.content.bytes().subarray(file.at, file.at + room.length);
        room.set(bytes);
        file.at += bytes.length;
        return bytes.length;
      });
      view().setUint32(at, read, true);
      return OK;
    },
    fd_write(fd, list, count, at) {
      const file = open.get(fd);
      if (!file || file.isRoot) return BAD_FILE;
      const written = each(list, count, (bytes) => {
        if (file.lines) {
          file.lines.write(bytes);
        } else {
          file.content.write(file.at, bytes);
          file.at += bytes.length;
        }
        return bytes.length;
      });
      view().setUint32(at, written, true);
      return OK;
    },
    fd_seek(fd, offset, whence, at) {
      const file = open.get(fd);
      if (!file?.content) return BAD_FILE;
      file.at = [0, file.at, file.content.length][whence] + Number(offset);
      view().setBigUint64(at, BigInt(file.at), true);
      return OK;
    },
    fd_sync: (fd) => (open.has(fd) ? OK : BAD_FILE),
    fd_close(fd) {
      const file = open.get(fd);
      if (file?.name) files.set(file.name, file.content.bytes());
      return open.delete(fd) ? OK : BAD_FILE;
    },
    fd_readdir(fd, at, length, cookie, used) {
      if (!open.get(fd)?.isRoot) return NO_DIRECTORY;
      const entries = [...files.keys()].slice(Number(cookie)).map((file, k) => {
        const text = encoded(file);
        const entry = new Uint8Array(24 + text.length);
        const fields = new DataView(entry.buffer);
        fields.setBigUint64(0, cookie + BigInt(k + 1), true);
        fields.setUint32(16, text.length, true);
        fields.setUint8(20, IS_FILE);
        entry.set(text, 24);
        return entry;
      });
      let end = 0;
      for (const entry of entries) {
        const part = entry.subarray(0, length - end);
        memory(at + end, part.length).set(part);
        end += part.length;
      }
      view().setUint32(used, end, true);
      return OK;
    },
    path_filestat_get(fd, flags, path, length, at) {
      const file = name(path, length);
      if (file === "") setStatus(at, IS_DIRECTORY, 0);
      else if (files.has(file)) setStatus(at, IS_FILE, files.get(file).length);
      else return NO_FILE;
      return OK;
    },
    path_open(fd, lookup, path, length, how, base, inheriting, flags, at) {
      const file = name(path, length);
      if (file === "") {
        open.set(next, { isRoot: true });
      } else if (how & DIRECTORY) {
        return files.has(file) ? NO_DIRECTORY : NO_FILE;
      } else if (!files.has(file) && !(how & CREATE)) {
        return NO_FILE;
      } else if (files.has(file) && how & EXCLUSIVE) {
        return EXISTS;
      } else {
        const isEmpty = how & TRUNCATE || !files.has(file);
        const content = new Content(isEmpty ? new Uint8Array(0) : files.get(file));
        // only what may be written is put back
        const isWritten = how & (CREATE | TRUNCATE);
        open.set(next, { content, at: 0, name: isWritten ? file : undefined });
      }
      view().setUint32(at, next++, true);
      return OK;
    },
    path_unlink_file: (fd, path, length) => (files.delete(name(path, length)) ? OK : NO_FILE),
  };
  const absent = () => NO_SUCH_CALL;
  const calls = WebAssembly.Module.imports(module).map(({ name }) => name);
  const system = Object.fromEntries(calls.map((call) => [call, known[call] ?? absent]));
  instance = new WebAssembly.Instance(module, { wasi_snapshot_preview1: system });
  try {
    instance.exports._start();
    return 0;
  } catch (error) {
    if (error instanceof Exit) return error.code;
    throw new Error([...said, String(error)].join("\n"));
  }
}
