// The recording's bytes: a header in JSON and columns of zigzag varints, deflated (emulator/page/columns.hpp).

interface Entry {
  name: string;
  at: number;
  size: number;
  count?: number;
  order?: number;
  unit?: number;
  text?: number;
}

async function inflated(bytes: Uint8Array): Promise<Uint8Array> {
  const stream = new Blob([bytes as BlobPart]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Varints of up to 53 bits, each added to what the ones before it foretell. */
export function numbers(bytes: Uint8Array, count: number, order: number, unit: number): Float64Array {
  const out = new Float64Array(count);
  let at = 0, before = 0, step = 0;
  for (let i = 0; i < count; ++i) {
    let low = 0, shift = 0, byte = bytes[at++];
    while (byte >= 0x80 && shift < 21) {
      low |= (byte & 0x7f) << shift;
      shift += 7;
      byte = bytes[at++];
    }
    let bits = low + (byte & 0x7f) * 2 ** shift;
    for (let scale = 2 ** (shift + 7); byte >= 0x80; scale *= 128) {
      byte = bytes[at++];
      bits += (byte & 0x7f) * scale;
    }
    const left = bits % 2 === 0 ? bits / 2 : -(bits + 1) / 2;
    const value = order === 0 ? left : order === 1 ? before + left : before + step + left;
    step = value - before;
    before = value;
    out[i] = value * unit;
  }
  if (at !== bytes.length) throw new Error("a column of the recording is damaged");
  return out;
}

export class Columns {
  readonly header: Record<string, unknown>;
  private readonly entries = new Map<string, Entry>();

  private constructor(private readonly bytes: Uint8Array) {
    const mark = new TextDecoder().decode(bytes.subarray(0, 8));
    if (mark !== "CMRCpage") throw new Error("the page holds no recording");
    const size = new DataView(bytes.buffer, bytes.byteOffset).getUint32(8, true);
    this.header = JSON.parse(new TextDecoder().decode(bytes.subarray(12, 12 + size)));
    if (this.header.format !== 1) throw new Error(`a recording of format ${this.header.format} is not known here`);
    this.bytes = bytes.subarray(12 + size);
    for (const entry of this.header.columns as Entry[]) this.entries.set(entry.name, entry);
  }

  static of(base64: string): Columns {
    const text = atob(base64.trim());
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    return new Columns(bytes);
  }

  has(name: string): boolean {
    return this.entries.has(name);
  }

  names(): string[] {
    return [...this.entries.keys()];
  }

  private async raw(name: string): Promise<[Entry, Uint8Array]> {
    const entry = this.entries.get(name);
    if (!entry) throw new Error(`the recording has no column ${name}`);
    return [entry, await inflated(this.bytes.subarray(entry.at, entry.at + entry.size))];
  }

  async numbers(name: string): Promise<Float64Array> {
    const [entry, bytes] = await this.raw(name);
    return numbers(bytes, entry.count!, entry.order!, entry.unit!);
  }

  async text(name: string): Promise<string> {
    return new TextDecoder().decode((await this.raw(name))[1]);
  }
}
