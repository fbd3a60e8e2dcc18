import type { Plugin } from 'vite'

export function packed(): Plugin
export function filesOf(folder: string): Promise<string[]>
