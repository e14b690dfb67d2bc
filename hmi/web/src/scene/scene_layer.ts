// One drawn thing: what every layer of a view can do.
import type { Object3D } from "three";

import type { Changed, ScreenState } from "../store";

export interface SceneLayer {
    readonly object: Object3D;
    /** Follows the store; says whether the picture changed. */
    update(state: ScreenState, changed: Changed): boolean;
    /** Advances what moves by itself (`nowMs` of the browser's clock); says whether it still moves. */
    animate?(nowMs: number): boolean;
    /** Told before the picture is drawn `heightPx` high: what has a least size on the glass keeps to it. */
    fit?(heightPx: number): void;
    /** Frees what the graphics memory holds. */
    dispose(): void;
}
