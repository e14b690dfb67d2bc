// Building the page without a framework: elements, and the shapes that stand beside every colour.
import type { Severity } from "../situation";

type Child = Node | string;

/** An element with classes ("a b"), attributes and children. */
export function element<K extends keyof HTMLElementTagNameMap>(
    tag: K,
    classes = "",
    attributes: Readonly<Record<string, string>> = {},
    ...children: readonly Child[]
): HTMLElementTagNameMap[K] {
    const made = document.createElement(tag);
    if (classes !== "") made.className = classes;
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
}

/** Sets text only when it differs, so that screen readers and layout are left in peace. */
export function say(target: HTMLElement, text: string): void {
    if (target.textContent !== text) target.textContent = text;
}

const svgSpace = "http://www.w3.org/2000/svg";
const shapes: Readonly<Record<Severity, readonly string[]>> = {
    normal: ["M12 2a10 10 0 1 0 0 20 10 10 0 0 0 0-20z", "M7.2 12.4l3.3 3.3 6.3-6.9"],
    attention: ["M12 2.4L23 21.6H1z", "M12 9.2v6M12 17.6v1.2"],
    fault: ["M3 3h18v18H3z", "M8 8l8 8M16 8l-8 8"],
};

/** Circle with a tick, triangle with a bang, square with a cross: readable without any colour. */
export function glyph(severity: Severity): SVGSVGElement {
    const svg = document.createElementNS(svgSpace, "svg");
    svg.setAttribute("viewBox", "0 0 24 24");
    svg.setAttribute("class", `glyph ${severity}`);
    svg.setAttribute("aria-hidden", "true");
    shapes[severity].forEach((d, i) => {
        const path = document.createElementNS(svgSpace, "path");
        path.setAttribute("d", d);
        path.setAttribute("class", i === 0 ? "ground" : "sign");
        svg.append(path);
    });
    return svg;
}

/** A place for a glyph that follows a severity. */
export class Glyph {
    readonly element = element("span", "glyph-place");
    private shown: Severity | null = null;

    show(severity: Severity): void {
        if (this.shown === severity) return;
        this.shown = severity;
        this.element.replaceChildren(glyph(severity));
    }
}
