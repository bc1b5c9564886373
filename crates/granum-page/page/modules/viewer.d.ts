// The viewer of grains is a module of granum-report, which the server gives under this name.
export function stage(title: string): HTMLDivElement;
export function show(root: ParentNode, data: unknown): (next: unknown) => void;
