// The page begins.
import './app/storage'
import { createPinia } from 'pinia'
import { createApp } from 'vue'
import App from './app/App.vue'
import { useNotices } from './app/notices'
import { makeRouter } from './app/router'
import './ui/base.css'

createApp(App).use(createPinia()).use(makeRouter()).mount('#app')
// What is loaded on demand has other names once labrun is updated; a click on it would do nothing.
addEventListener('vite:preloadError', () => useNotices().tell('This part did not load: labrun may have been updated. Reload the page; unsaved protocols are kept.', { level: 'problem' }))
