// A small picture with text for the scene: drawn once on a canvas, always turned to the viewer, of constant size.
import { CanvasTexture, Sprite, SpriteMaterial, SRGBColorSpace } from "three";

/** Draws on a square or wide canvas of `width` x `height` pixels. */
export type Draw = (context: CanvasRenderingContext2D, width: number, height: number) => void;

export class Label {
    readonly sprite: Sprite;
    private readonly texture: CanvasTexture;

    constructor(
        private readonly width: number,
        private readonly height: number,
        draw: Draw,
        depthTest = false,
    ) {
        const canvas = document.createElement("canvas");
        canvas.width = width;
        canvas.height = height;
        const context = canvas.getContext("2d");
        if (context !== null) draw(context, width, height);
        this.texture = new CanvasTexture(canvas);
        this.texture.colorSpace = SRGBColorSpace;
        this.sprite = new Sprite(
            new SpriteMaterial({ map: this.texture, depthTest, depthWrite: false, sizeAttenuation: false }),
        );
    }

    /** Height as a share of the picture's height. */
    resize(share: number, fovDegrees: number): void {
        // Sprites without attenuation are sized as if they stood at distance 1.
        const height = share * 2 * Math.tan((fovDegrees * Math.PI) / 360);
        this.sprite.scale.set((height * this.width) / this.height, height, 1);
    }

    dispose(): void {
        this.texture.dispose();
        this.sprite.material.dispose();
    }
}
