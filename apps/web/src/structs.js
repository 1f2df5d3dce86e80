// The structures of cosplat.h in a module's memory. Their layout comes from the module itself
// (module/layout.cpp). Fields are camelCase here, snake_case there.

const BYTES = { u32: 4, f32: 4, i64: 8, u64: 8, text: 4, pointer: 4 };

// The module's memory. It may have grown in another thread, which only the memory itself knows.
export function heap(module) {
  const buffer = module.wasmMemory?.buffer ?? module.HEAPU8.buffer;
  return new Uint8Array(buffer);
}

const camelCase = (name) => name.replace(/_([a-z])/g, (_, letter) => letter.toUpperCase());

export class Structs {
  constructor(module) {
    this.module = module;
    const text = module._cosplat_web_layout();
    this.layout = JSON.parse(this.text(text));
    this.blocks = new Map();
  }

  // A string of C's.
  text(pointer) {
    const bytes = heap(this.module);
    // Decoders refuse shared memory, so a copy.
    return new TextDecoder().decode(bytes.slice(pointer, bytes.indexOf(0, pointer)));
  }

  // The one structure of that name, zeroed but for its size.
  clear(name) {
    const { bytes, fields } = this.layout[name];
    if (!this.blocks.has(name)) this.blocks.set(name, this.module._malloc(bytes));
    const at = this.blocks.get(name);
    heap(this.module).fill(0, at, at + bytes);
    if (fields.struct_size) this.write(at, fields.struct_size, bytes);
    return at;
  }

  // The one structure of that name with these values; the others are zero. A value that is
  // undefined, and a key that the structure does not have, is left out.
  fill(name, values) {
    const at = this.clear(name);
    for (const [field, place] of Object.entries(this.layout[name].fields)) {
      const value = values[camelCase(field)];
      if (value !== undefined) this.write(at, place, value);
    }
    return at;
  }

  write(at, [type, offset, count], value) {
    const view = new DataView(heap(this.module).buffer, at + offset, count * BYTES[type]);
    const values = count > 1 ? value : [value];
    if (values.length !== count) throw new TypeError(`expected ${count} numbers, not ${values.length}`);
    for (let i = 0; i < count; ++i) {
      if (type === "f32") view.setFloat32(4 * i, values[i], true);
      else if (BYTES[type] === 8) view.setBigInt64(8 * i, BigInt(values[i]), true);
      else view.setUint32(4 * i, values[i], true);
    }
  }

  // All fields but struct_size: numbers, arrays of them, texts.
  read(name, at = this.blocks.get(name)) {
    const out = {};
    for (const [field, [type, offset, count]] of Object.entries(this.layout[name].fields)) {
      if (field === "struct_size") continue;
      const view = new DataView(heap(this.module).buffer, at + offset, count * BYTES[type]);
      const one = (i) => {
        if (type === "f32") return view.getFloat32(4 * i, true);
        if (type === "i64") return Number(view.getBigInt64(8 * i, true));
        if (type === "u64") return Number(view.getBigUint64(8 * i, true));
        const word = view.getUint32(4 * i, true);
        return type === "text" ? this.text(word) : word;
      };
      out[camelCase(field)] = count > 1 ? Array.from({ length: count }, (_, i) => one(i)) : one(0);
    }
    return out;
  }
}
