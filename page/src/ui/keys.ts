// Commands of the keyboard, unless an input field uses the key.
import { SPEEDS, type State } from "./state";

export interface Actions {
  miss(by: number): void;
  event(): void;
  focus(): number;
  picture(): void;
  home(): void;
  theme(): void;
  help(): void;
  escape(): void;
}

export function keys(state: State, actions: Actions): void {
  const speed = (by: number): void => state.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(state.speed) + by))]);
  const step = (by: number): void => {
    state.seek(state.now + (by * (state.to - state.from)) / 100);
    state.follow();
  };
  const table: Record<string, () => void> = {
    " ": () => state.play(!state.playing), ArrowLeft: () => step(-1), ArrowRight: () => step(1), "+": () => state.zoom(0.5, actions.focus()),
    "=": () => state.zoom(0.5, actions.focus()), "-": () => state.zoom(2, actions.focus()), "0": () => state.whole(), "[": () => speed(-1), "]": () => speed(1),
    n: () => actions.miss(1), p: () => actions.miss(-1), e: () => actions.event(), r: () => state.set("rays", !state.options.rays),
    g: () => state.set("ghost", !state.options.ghost), l: () => state.set("path", !state.options.path), h: () => actions.home(), d: () => actions.theme(),
    s: () => actions.picture(), "?": () => actions.help(), Escape: () => actions.escape(), Home: () => state.seek(state.begin), End: () => state.seek(state.end),
  };
  addEventListener("keydown", (event) => {
    // Brackets need AltGr or an option key on many keyboards; with AltGr some systems tell of Ctrl and Alt.
    const typed = event.getModifierState("AltGraph") || (event.altKey && (event.key === "[" || event.key === "]"));
    if (event.metaKey || ((event.ctrlKey || event.altKey) && !typed)) return;
    const on = event.target as HTMLElement, act = table[event.key];
    const taken = on.tagName === "SELECT" || (on.tagName === "INPUT" && /^(Arrow|Home|End| )/.test(event.key)) || (on.tagName === "BUTTON" && event.key === " ");
    if (!act || taken) return;
    event.preventDefault();
    act();
  });
}
