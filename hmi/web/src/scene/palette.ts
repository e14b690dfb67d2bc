// The colours of the drawn world: greys for what is well, red for defects alone.
export const palette = {
    part: 0xc0c7cc,
    partEdges: 0x5f6a72,
    partUnlocked: 0xd6dadc,
    floor: 0xd5d9dc,
    floorLines: 0xb9c0c4,
    worker: 0x93a3ae,
    pointer: 0x1b2226,
    sensor: 0x5c6870,
    sensorAbnormal: 0xb45309,
    defect: "#d4001a",
    withdrawn: "#6d7880",
    ink: "#1b2226",
    paper: "#ffffff",
} as const;
