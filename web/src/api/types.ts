// The models of the API as types: `Received<'DeviceState'>` is what the server sends, `Sent<'StartRun'>` what it accepts.
import type { components } from './types.gen'

type Schemas = components['schemas']

/** The server sends every field; the API description calls those with a default optional. */
export type Whole<T> = T extends object ? { readonly [K in keyof T]-?: Whole<Exclude<T[K], undefined>> } : T

export type Received<Name extends keyof Schemas> = Whole<Schemas[Name]>
export type Sent<Name extends keyof Schemas> = Schemas[Name]

export type Fault = Received<'Fault'>
export type Problem = Received<'FoundProblem'>
export type DeviceState = Received<'DeviceState'>
export type DeviceDetail = Received<'DeviceDetail'>
export type ActionForm = Received<'ActionForm'>
export type GoalState = Received<'GoalState'>
export type JogState = Received<'JogState'>
export type ControlState = Received<'ControlState'>
export type RunSummary = Received<'RunSummary'>
export type FoundRun = Received<'FoundRun'>
export type RunDetail = Received<'RunDetail'>
export type LaunchState = Received<'LaunchState'>
export type Snapshot = Received<'Snapshot'>
export type Patch = Received<'Patch'>
export type RunPatch = Received<'RunPatch'>
export type RunLog = Received<'RunLog'>
export type Notice = Received<'Notice'>
export type WatchedRun = Received<'WatchedRun'>
export type Stopped = Received<'Stopped'>
export type Settings = Received<'Settings'>
export type AllSettings = Received<'AllSettings'>
export type Session = Received<'Session'>
