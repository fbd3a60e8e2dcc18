// Measured on the plot of a spectrum: new counts over 22,800 channels, until they are in the canvas.
import { createApp, h, nextTick, shallowRef } from 'vue'
import SpectrumPlot from '../../src/results/SpectrumPlot.vue'
import { frame, type Figures } from './measures'
import { CHANNELS } from './pretended'

const TIMES = 60

/** A spectrum with noise and lines; the same for the same seed. */
function counts(seed: number): Float32Array {
  let state = seed
  const random = (): number => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648
  const made = Float32Array.from({ length: CHANNELS }, () => 200 + 40 * random())
  for (let line = 0; line < 80; line++) {
    const at = Math.floor(random() * CHANNELS)
    const height = 40_000 * random() ** 4
    for (let i = Math.max(0, at - 12); i < Math.min(CHANNELS, at + 12); i++) made[i] = (made[i] ?? 0) + height / (1 + ((i - at) / 3) ** 2)
  }
  return made
}

export async function measureSpectrum(): Promise<Figures> {
  const nm = Float32Array.from({ length: CHANNELS }, (_, i) => 190 + (i * 760) / (CHANNELS - 1))
  const spectra = Array.from({ length: 8 }, (_, i) => counts(i + 1))
  const curves = shallowRef([{ name: 'raw', values: spectra[0] ?? nm, colour: '#0b5cad' }])
  const app = createApp({ render: () => h(SpectrumPlot, { nm, curves: curves.value, peaks: [], height: 300, label: 'benchmark', style: 'width: 900px' }) })
  app.mount('#app')
  for (let i = 0; i < 10; i++) await frame()
  const canvas = document.querySelector('canvas')
  const ctx = canvas?.getContext('2d')
  if (!ctx) throw new Error('no spectrum was drawn')
  const ms: number[] = []
  for (let i = 0; i < TIMES; i++) {
    await frame()
    const began = performance.now()
    curves.value = [{ name: 'raw', values: spectra[i % spectra.length] ?? nm, colour: '#0b5cad' }]
    await nextTick()
    await Promise.resolve()
    ms.push(performance.now() - began)
    await frame()
  }
  if (!ctx.getImageData(0, 0, canvas?.width ?? 1, canvas?.height ?? 1).data.some((value) => value > 0)) throw new Error('the canvas is empty')
  app.unmount()
  return { title: 'spectrum of 22,800 channels: redrawn with new counts', ms, budget_ms: 10 }
}
