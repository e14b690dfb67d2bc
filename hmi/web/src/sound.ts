// The tick that says "your mark is in the record": two rising tones, only for marks that arrived while watching.
import type { Store } from "./store";

const tones = [
    { hertz: 880, at: 0, length: 0.12 },
    { hertz: 1318.5, at: 0.13, length: 0.22 },
];

export class Sound {
    private context: AudioContext | null = null;
    private heard = new Set<number>();
    private readonly unwatch: () => void;

    constructor(private readonly store: Store) {
        this.unwatch = store.watch(["arrivals"], (state) => this.follow(state.arrivals));
    }

    /** Browsers stay silent until someone touches the page: call it from that touch. */
    async turnOn(): Promise<void> {
        this.context ??= new AudioContext();
        await this.context.resume();
        this.store.update({ sound: this.context.state === "running" ? "on" : "off" });
        this.play();
    }

    async turnOff(): Promise<void> {
        await this.context?.suspend();
        this.store.update({ sound: "off" });
    }

    dispose(): void {
        this.unwatch();
        void this.context?.close();
    }

    private follow(arrivals: ReadonlyMap<number, number>): void {
        const fresh = [...arrivals.keys()].some((id) => !this.heard.has(id));
        this.heard = new Set(arrivals.keys());
        if (fresh && this.store.state.sound === "on") this.play();
    }

    private play(): void {
        const context = this.context;
        if (context === null || context.state !== "running") return;
        for (const tone of tones) {
            const oscillator = context.createOscillator();
            const volume = context.createGain();
            const start = context.currentTime + tone.at;
            oscillator.type = "triangle";
            oscillator.frequency.value = tone.hertz;
            volume.gain.setValueAtTime(0, start);
            volume.gain.linearRampToValueAtTime(0.5, start + 0.01);
            volume.gain.exponentialRampToValueAtTime(0.001, start + tone.length);
            oscillator.connect(volume).connect(context.destination);
            oscillator.start(start);
            oscillator.stop(start + tone.length);
        }
    }
}
