// The drawn picture: the chosen view large, the other as an inset; renders only when something changed.
import { Box3, Vector3, WebGLRenderer } from "three";

import type { Changed, ScreenState, StateKey, Store, ViewName } from "../store";
import { FloorLayer } from "./floor_layer";
import { extentOf, frontDirection } from "./front_side";
import { MarksLayer } from "./marks_layer";
import { Pace } from "./pace";
import { PartLayer } from "./part_layer";
import { PointingLayer } from "./pointing_layer";
import { type Covered, SceneView } from "./scene_view";
import { SensorsLayer } from "./sensors_layer";
import { WorkerLayer } from "./worker_layer";

const followed: readonly StateKey[] = [
    "live", "now", "link", "mesh", "cell", "marks", "arrivals", "voxels", "selectedMark", "view",
];
const nothing: Covered = { left: 0, bottom: 0 };
const drawingShare = 0.4;
const longestPauseMs = 400;
const longestDrawingMs = 2000;
const lookAgainMs = 4;
const pickShare = 0.04; // how near a tap must be to a dot, of the picture's height
const other: Readonly<Record<ViewName, ViewName>> = { part: "cell", cell: "part" };

export class Stage {
    private readonly renderer: WebGLRenderer;
    private readonly views: Readonly<Record<ViewName, SceneView>>;
    private readonly partMarks: Readonly<Record<ViewName, MarksLayer>>;
    private readonly sizes: ResizeObserver;
    private readonly unwatch: () => void;
    private readonly pace = new Pace(drawingShare, longestPauseMs);
    private waiting = 0; // the timer of a pause or of a picture being drawn
    private moving = false;
    private missed = false; // something changed while waiting
    private scheduled = 0;

    /** Draws into `container`; `inset` is the element over which the other view is drawn. Throws without WebGL. */
    constructor(
        private readonly container: HTMLElement,
        private readonly inset: HTMLElement,
        private readonly store: Store,
    ) {
        this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
        this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
        this.renderer.setScissorTest(true);
        this.renderer.autoClear = false;
        const canvas = this.renderer.domElement;
        container.prepend(canvas);

        const onMove = () => this.schedule();
        const part = new SceneView(canvas, onMove);
        const cell = new SceneView(canvas, onMove);
        this.views = { part, cell };
        this.partMarks = {
            part: new MarksLayer("part", part.camera, 0.046),
            cell: new MarksLayer("world", cell.camera, 0.034),
        };
        part.add(new PartLayer("part"));
        part.add(new PointingLayer("part", part.camera, 0.0035, 0.07));
        part.add(this.partMarks.part);
        cell.add(new FloorLayer());
        cell.add(new PartLayer("world"));
        cell.add(new WorkerLayer());
        cell.add(new SensorsLayer(cell.camera, 0.035));
        cell.add(new PointingLayer("world", cell.camera, 0.009, 0.05));
        cell.add(this.partMarks.cell);

        canvas.addEventListener("click", (event) => this.pick(event));
        this.sizes = new ResizeObserver(() => this.resize());
        this.sizes.observe(container);
        this.sizes.observe(inset);
        this.unwatch = store.watch(followed, (state, changed) => this.follow(state, changed));
    }

    goHome(): void {
        this.views[this.store.state.view].goHome();
        this.schedule();
    }

    dispose(): void {
        this.unwatch();
        this.sizes.disconnect();
        window.clearTimeout(this.waiting);
        cancelAnimationFrame(this.scheduled);
        this.views.part.dispose();
        this.views.cell.dispose();
        this.renderer.dispose();
        this.renderer.domElement.remove();
    }

    private follow(state: ScreenState, changed: Changed): void {
        let drawn = changed.has("view");
        if (changed.has("mesh") && state.mesh !== null) {
            const extent = extentOf(state.mesh);
            const front = new Vector3(...frontDirection(state.mesh));
            front.z = 0.28; // a standing person looks down at it
            this.views.part.frame(new Box3(new Vector3(...extent.min), new Vector3(...extent.max)), front, 1.08);
        }
        if (changed.has("cell")) {
            const box = state.cell?.box ?? { min: [-2, -1.5, 0] as const, max: [2, 1.5, 2.2] as const };
            // What matters happens well inside the cell: its corners may leave the picture.
            const inner = new Box3(new Vector3(...box.min), new Vector3(...box.max));
            const size = inner.getSize(new Vector3());
            inner.expandByVector(new Vector3(-0.24 * size.x, -0.16 * size.y, -0.05 * size.z));
            this.views.cell.frame(inner, new Vector3(1, -0.5, 0.4), 0.86);
        }
        if (changed.has("view"))
            for (const name of ["part", "cell"] as const) this.views[name].active = name === state.view;
        for (const name of ["part", "cell"] as const) drawn = this.views[name].update(state, changed) || drawn;
        if (drawn) this.schedule();
    }

    private pick(event: MouseEvent): void {
        const { left, top, width, height } = this.renderer.domElement.getBoundingClientRect();
        const x = ((event.clientX - left) / width) * 2 - 1;
        const y = 1 - ((event.clientY - top) / height) * 2;
        const selectedMark = this.partMarks[this.store.state.view].at(x, y, width / height, pickShare);
        this.store.update({ selectedMark });
    }

    private resize(): void {
        this.renderer.setSize(this.container.clientWidth, this.container.clientHeight);
        this.schedule();
    }

    private schedule(): void {
        this.missed = true;
        if (this.scheduled !== 0 || this.waiting !== 0) return;
        const wait = this.pace.wait(performance.now());
        if (wait === 0) {
            this.scheduled = requestAnimationFrame((now) => this.render(now));
            return;
        }
        this.waiting = window.setTimeout(() => {
            this.waiting = 0;
            this.schedule();
        }, wait);
    }

    private render(now: number): void {
        this.scheduled = 0;
        const whole = this.container.getBoundingClientRect();
        const corner = this.inset.getBoundingClientRect();
        if (whole.width === 0 || whole.height === 0) return;
        const begin = performance.now();
        const { view } = this.store.state;
        let moving = this.views[view].animate(now);
        moving = this.views[other[view]].animate(now) || moving;
        // A part is wide and has room above the inset, a cell is high and has room beside it.
        const covered =
            view === "part"
                ? { left: 0, bottom: whole.bottom - corner.top }
                : { left: (corner.right - whole.left) * 0.8, bottom: 0 };
        this.draw(view, 0, 0, whole.width, whole.height, covered);
        this.draw(other[view], corner.left - whole.left, whole.bottom - corner.bottom, corner.width, corner.height, nothing);
        this.moving = moving;
        this.watchDrawing(begin);
    }

    /** Drawing goes on behind our back, slowly where the processor does it: no new picture before this one is done. */
    private watchDrawing(begin: number): void {
        const context = this.renderer.getContext() as WebGL2RenderingContext;
        const fence = context.fenceSync(context.SYNC_GPU_COMMANDS_COMPLETE, 0);
        context.flush();
        const look = () => {
            const done = fence === null || context.getSyncParameter(fence, context.SYNC_STATUS) === context.SIGNALED;
            if (!done && performance.now() - begin < longestDrawingMs && !context.isContextLost()) {
                this.waiting = window.setTimeout(look, lookAgainMs);
                return;
            }
            if (fence !== null) context.deleteSync(fence);
            this.pace.drawn(begin, performance.now());
            this.waiting = 0;
            if (this.moving || this.missed) this.schedule();
        };
        this.missed = false;
        this.waiting = window.setTimeout(look, lookAgainMs);
    }

    private draw(name: ViewName, x: number, y: number, width: number, height: number, covered: Covered): void {
        this.renderer.setViewport(x, y, width, height);
        this.renderer.setScissor(x, y, width, height);
        this.renderer.clear();
        this.views[name].render(this.renderer, width, height, covered);
    }
}
