// The words of the API as types: `Told<'DeviceState'>` is what the server says, `Asked<'StartRun'>` what it takes.
import type { components } from './types.gen'

type Schemas = components['schemas']

/** The server sends every field; its description calls those with a default optional. */
export type Whole<T> = T extends object ? { readonly [K in keyof T]-?: Whole<Exclude<T[K], undefined>> } : T

export type Told<Name extends keyof Schemas> = Whole<Schemas[Name]>
export type Asked<Name extends keyof Schemas> = Schemas[Name]

export type Fault = Told<'Fault'>
export type Problem = Told<'FoundProblem'>
export type DeviceState = Told<'DeviceState'>
export type DeviceDetail = Told<'DeviceDetail'>
export type ActionForm = Told<'ActionForm'>
export type GoalState = Told<'GoalState'>
export type JogState = Told<'JogState'>
export type ControlState = Told<'ControlState'>
export type RunSummary = Told<'RunSummary'>
export type RunDetail = Told<'RunDetail'>
export type LaunchState = Told<'LaunchState'>
export type Snapshot = Told<'Snapshot'>
export type Patch = Told<'Patch'>
export type RunPatch = Told<'RunPatch'>
export type RunLog = Told<'RunLog'>
export type Notice = Told<'Notice'>
export type Watched = Told<'Watched'>
export type Stopped = Told<'Stopped'>
export type Settings = Told<'Settings'>
export type AllSettings = Told<'AllSettings'>
export type Session = Told<'Session'>
