// A link to an instant, a stretch of time and a miss: #t=12.345678&from=12.3&to=12.4&miss=pid:0:1234
import type { State } from "./state";

export interface Place {
  t?: number;
  from?: number;
  to?: number;
  miss?: string;
}

export function read(hash: string): Place {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const number = (name: string): number | undefined => {
    const value = given.get(name);
    return value !== null && value.trim() !== "" && Number.isFinite(Number(value)) ? Number(value) : undefined;
  };
  return { t: number("t"), from: number("from"), to: number("to"), miss: given.get("miss") ?? undefined };
}

export function written(state: State, miss: string | null): string {
  const parts = [`t=${trimmed(state.now)}`];
  if (state.from > state.begin || state.to < state.end) parts.push(`from=${trimmed(state.from)}`, `to=${trimmed(state.to)}`);
  if (miss !== null) parts.push(`miss=${encodeURIComponent(miss).replaceAll("%3A", ":")}`);
  return `#${parts.join("&")}`;
}

function trimmed(seconds: number): string {
  return seconds.toFixed(7).replace(/0+$/, "").replace(/\.$/, "");
}
